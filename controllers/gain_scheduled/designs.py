"""Tables of which this process made laws: a law is numbers alone, and tells its design by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

NODES = ("envelope", "frequency", "bandwidth")
"""Quantities that a table is a grid over; the first fields of its law, with the cells after them."""

AS_DESIGNED = {"load": 1.0, "effort": 1.0}
"""Fields that change the loop, as the margins of a table take them; its filters are in the table."""

_behind: dict[tuple[Any, ...], Mapping[str, Any]] = {}


def remember(law: Any, content: Mapping[str, Any]) -> None:
    """Keep the table that a law was made of."""
    _behind[law[: len(NODES) + 1]] = content


def designed(law: Any) -> dict[str, Any] | None:
    """What the table of a law tells of its design, see `gyroctl.harness.protocol.Designed`.

    Parameters
    ----------
    law : Scheduled
        Of a table that was read in this process.

    Returns
    -------
    dict or None
        None where the table is not known, or carries no margins.
    """
    content = _behind.get(law[: len(NODES) + 1])
    if content is None or not all(isinstance(cell.get("margins"), Mapping) for cell in content["cells"]):
        return None
    told = content.get("provenance", {})
    meant = {**AS_DESIGNED, **content["filters"]}
    cells = [
        {
            **{name: cell[name] for name in NODES},
            "wave_height": cell["wave_height"],
            "share": cell["point"]["share"],
            "margins": cell["margins"],
        }
        for cell in content["cells"]
    ]
    differs = {name: getattr(law, name) for name, value in meant.items() if getattr(law, name) != value}
    return {"plant": told.get("plant", ""), "method": told.get("method", ""), "differs": differs, "cells": cells}
