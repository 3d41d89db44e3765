"""Gain-scheduled laws from the linear models along the locked orbits: `design` writes their tables, slowly."""

from __future__ import annotations

from functools import partial

from gyroctl.controllers.gain_scheduled.scheduled import Scheduled, ScheduledState
from gyroctl.controllers.gain_scheduled.table import law_of, lost_by, name_for, read_table, table_file
from gyroctl.plant import Plant

__all__ = ["Scheduled", "ScheduledState", "law_of", "read_table", "scheduled_lmi", "scheduled_lqr", "table_file"]


def tabled(
    name: str,
    load: float = 1.0,
    effort: float = 1.0,
    plant: Plant | None = None,
    *,
    cc_min: float,
    cc_max: float,
    cg_max: float,
    wp: float = 3.14,
) -> Scheduled:
    """Law by a shipped table.

    Parameters
    ----------
    name : str
        Of the table.
    load : float
        Factor on the share of the lock capacity that the generator takes. [-]
    effort : float
        Factor on the feedback; the cells' gain margins tell how much it may rise. [-]
    plant : Plant, optional
        The design model: beyond the linear one the table is that of the realistic device, and what bearing and windage
        of this device take of the lock capacity is not asked of the generator.
    cc_min, cc_max, cg_max : float
        Limits of the command. [Nms]
    wp : float
        Peak frequency at the start. [rad/s]

    Raises
    ------
    InputError
        Where no table ships for the design model.
    """
    table = read_table(table_file(name_for(name, plant)))
    known = {} if plant is None else lost_by(plant)
    return law_of(table, load=load, effort=effort, cc_min=cc_min, cc_max=cc_max, cg_max=cg_max, wp=wp, **known)


scheduled_lqr = partial(tabled, "scheduled_lqr", cc_min=0.0468, cc_max=0.1724, cg_max=0.02)
"""Law by the table of the periodic LQR."""

scheduled_lmi = partial(tabled, "scheduled_lmi", cc_min=0.05, cc_max=0.12, cg_max=0.02)
"""Law by the table of the LMI design, one Lyapunov function over the schedule."""
