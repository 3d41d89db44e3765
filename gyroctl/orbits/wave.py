"""The regular wave that holds an orbit: what is asked of it, and the plain one that orbits keep."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@runtime_checkable
class RegularWave(Protocol):
    """What the orbit needs to know of a regular wave."""

    @property
    def height(self) -> float:
        """Wave height. [m]"""

    @property
    def wp(self) -> float:
        """Angular frequency. [rad/s]"""

    @property
    def heading(self) -> float:
        """Heading. [deg]"""


@dataclass(frozen=True)
class Wave:
    """A regular wave as the orbit sees it: height [m], angular frequency wp [rad/s] and heading [deg]."""

    height: float
    wp: float
    heading: float = 0.0
