"""Gain-scheduled laws from the linear models along the locked orbits: `design` writes their tables, slowly."""

from __future__ import annotations

from gyroctl.controllers.gain_scheduled.scheduled import Scheduled, ScheduledState
from gyroctl.controllers.gain_scheduled.table import law_of, read_table, table_file

__all__ = ["Scheduled", "ScheduledState", "law_of", "read_table", "scheduled_lmi", "scheduled_lqr", "table_file"]


def scheduled_lqr(
    load: float = 1.0,
    effort: float = 1.0,
    cc_min: float = 0.0468,
    cc_max: float = 0.1724,
    cg_max: float = 0.02,
    wp: float = 3.14,
) -> Scheduled:
    """Law by the table of the periodic LQR.

    Parameters
    ----------
    load : float
        Factor on the share of the lock capacity that the generator takes. [-]
    effort : float
        Factor on the feedback; the cells' gain margins tell how much it may rise. [-]
    cc_min, cc_max, cg_max : float
        Limits of the command. [Nms]
    wp : float
        Peak frequency at the start. [rad/s]
    """
    return _law("scheduled_lqr", load, effort, cc_min, cc_max, cg_max, wp)


def scheduled_lmi(
    load: float = 1.0,
    effort: float = 1.0,
    cc_min: float = 0.05,
    cc_max: float = 0.12,
    cg_max: float = 0.02,
    wp: float = 3.14,
) -> Scheduled:
    """Law by the table of the LMI design, one Lyapunov function over the schedule.

    Parameters
    ----------
    load : float
        Factor on the share of the lock capacity that the generator takes. [-]
    effort : float
        Factor on the feedback; the cells' gain margins tell how much it may rise. [-]
    cc_min, cc_max, cg_max : float
        Limits of the command. [Nms]
    wp : float
        Peak frequency at the start. [rad/s]
    """
    return _law("scheduled_lmi", load, effort, cc_min, cc_max, cg_max, wp)


def _law(name: str, load: float, effort: float, cc_min: float, cc_max: float, cg_max: float, wp: float) -> Scheduled:
    return law_of(
        read_table(table_file(name)), load=load, effort=effort, cc_min=cc_min, cc_max=cc_max, cg_max=cg_max, wp=wp
    )
