"""A law that runs as plain Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class UserLaw:
    """Any function as a law, run as plain Python."""

    call: Callable[[float, Any, Any], Any]
    period: float = 0.1
    information: Any = "sensors"

    def init(self) -> Any:
        return None

    def step(self, t: float, y: Any, state: Any) -> Any:
        return self.call(t, y, state)
