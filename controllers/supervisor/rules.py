"""The supervisor's rules: in which mode the device is, and what is commanded there. Floats only, compiled or not.

A locked ring is a synchronous machine, and it is started as one: first the machine that turns it is brought to speed,
then the ring is coupled to it, then the load is put on.

- START. The generator serves as a motor on the flywheel, the ring is hardly coupled to it. A negative generator gain
  gives the torque ``-cg omega'``, none at a flywheel at rest: but the float turns the flywheel's casing to and fro, and
  of that motion relative to the ring the motor feeds the right half wave and brakes the wrong one, until it grows.
  Its gain and its power are limited.
- PULL. The coupling drags the ring to the flywheel's speed; it slips past the waves until their phase holds it. Meant
  to be tight: the float's swing in phi1 at 1.2 rad/s that a start leaves behind dies away in 400 s at cc = 0.052, in
  150 s at 0.1 and in 100 s at 0.3, and grows below 0.03 (Floquet multipliers of the locked orbit, wave of 0.2 m). The
  motor drives the flywheel on, past the speed at which the ring is caught, until it is in step. Lock is believed when
  the ring has kept the waves' speed for a while, at an angle to the float's motion at which that motion drives it,
  ``U1 > 0`` in ``u1 + i u3 = exp(i psi)(phi1' + i phi3')``.
- PRODUCE. The wrapped law has the controls. It is handed them over along a ramp: generator from zero, coupling from
  the one of PULL, so that neither jumps; and its integrators begin at the beginning of PULL.
- UNLOAD. The ring falls behind: generator off, coupling fixed, so that the flywheel drags the ring along. If it comes
  back, PRODUCE again along the ramp; if not, PULL where the flywheel is fast enough, else START.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gyroctl.plant.compiled import inlined

START, PULL, PRODUCE, UNLOAD = 0.0, 1.0, 2.0, 3.0
MODES = ("start", "pull", "produce", "unload")
"""Names of the modes by number."""


class Rules(NamedTuple):
    """What the supervisor goes by."""

    motor_gain: float = 0.02  # largest negative generator gain asked for [Nms]
    motor_power: float = 30.0  # largest power of the motor [W]
    speed_ratio: float = 0.8  # flywheel speed at which the ring is coupled to it, as a part of N wp [-]
    top_ratio: float = 1.0  # up to which the motor drives it on, until the ring is in step [-]
    cc_start: float = 0.0  # coupling while the flywheel is brought to speed [Nms]
    cc_pull: float = 0.15  # coupling while the ring is dragged into step, and while unloaded [Nms]
    tolerance: float = 0.15  # deviation of the ring speed from wp at which lock is believed, as a part of wp [-]
    confirm: float = 5.0  # time for which it must stay within [s]
    patience: float = 60.0  # after which a ring that is not caught is let go again [s]
    handover: float = 20.0  # length of the ramp to the wrapped law [s]
    behind: float = 0.6  # mean ring speed below which the device is unloaded, as a part of wp [-]
    stalled: float = 0.3  # below which it is taken for lost [-]
    recovery: float = 15.0  # time that an unloaded ring is given to come back [s]
    window: float = 2.5  # time constant of the mean ring speed and of U1, U3 [s]
    wp: float = 3.14  # peak frequency, the speed that the ring is to keep [rad/s]
    N: float = 22.555555555555557  # gear ratio [-]


class Watch(NamedTuple):
    """What the supervisor remembers: mode, filters, counters."""

    mode: float  # see MODES [-]
    since: float  # time in this mode [s]
    steady: float  # time for which the ring has kept the waves' speed [s]
    share: float  # part of the wrapped law in the command [-]
    fresh: float  # 1 in the sample at which the wrapped law begins anew [-]
    speed: float  # mean ring speed [rad/s]
    U1: float  # [rad/s]
    U3: float  # [rad/s]
    begun: float  # 1 after the first sample [-]
    starts: float  # times that START was entered [-]
    pulls: float  # times that PULL was entered [-]
    catches: float  # locks handed over to the wrapped law after PULL [-]
    unloads: float  # times that UNLOAD was entered [-]
    time_start: float  # time spent in START [s]
    time_pull: float  # in PULL [s]
    time_produce: float  # in PRODUCE [s]
    time_unload: float  # in UNLOAD [s]
    clipped: float  # samples at which the wrapped law asked for a negative generator gain [-]


def first_watch() -> Watch:
    """Before the first sample."""
    return Watch(*[0.0] * len(Watch._fields))


@inlined
def observe(rules: Rules, period: float, y: Any, watch: Watch) -> Watch:
    """Filter the measurement `y` and decide on the mode for the `period` [s] that follows."""
    c, s = math.cos(y.psi), math.sin(y.psi)
    u1 = c * y.phi1_rate - s * y.phi3_rate
    u3 = s * y.phi1_rate + c * y.phi3_rate
    first = watch.begun == 0.0
    part = 1.0 if first else 1.0 - math.exp(-period / rules.window)
    speed = watch.speed + part * (y.psi_rate - watch.speed)
    U1 = watch.U1 + part * (u1 - watch.U1)
    U3 = watch.U3 + part * (u3 - watch.U3)
    in_step = abs(speed - rules.wp) <= rules.tolerance * rules.wp and U1 > 0.0
    steady = watch.steady + period if in_step else 0.0
    fast = y.omega_rate >= rules.speed_ratio * rules.N * rules.wp

    mode, since, share = watch.mode, watch.since + period, watch.share
    if first:
        since = 0.0
        turning = y.psi_rate > rules.behind * rules.wp and y.omega_rate > rules.behind * rules.N * rules.wp
        mode = PRODUCE if turning else START
        share = 1.0 if turning else 0.0  # a device that is found locked is the wrapped law's from the first sample on
    elif mode == START:
        if fast:
            mode = PULL
    elif mode == PULL:
        if steady >= rules.confirm:
            mode = PRODUCE
        elif since >= rules.patience:
            mode = START
    elif mode == PRODUCE:
        share = min(share + period / rules.handover, 1.0)
        if speed < rules.behind * rules.wp:
            mode = UNLOAD
    elif steady >= rules.confirm:
        mode = PRODUCE
    elif since >= rules.recovery or speed < rules.stalled * rules.wp:
        mode = PULL if fast else START

    changed = first or mode != watch.mode
    caught = mode == PRODUCE and changed and watch.mode == PULL and not first
    if changed:
        since = 0.0
        if mode != PRODUCE:
            share = 0.0
            steady = 0.0
    fresh = 1.0 if (changed and mode == PULL) or first else 0.0
    return Watch(
        mode,
        since,
        steady,
        share,
        fresh,
        speed,
        U1,
        U3,
        1.0,
        watch.starts + (1.0 if changed and mode == START else 0.0),
        watch.pulls + (1.0 if changed and mode == PULL else 0.0),
        watch.catches + (1.0 if caught else 0.0),
        watch.unloads + (1.0 if changed and mode == UNLOAD else 0.0),
        watch.time_start + (period if mode == START else 0.0),
        watch.time_pull + (period if mode == PULL else 0.0),
        watch.time_produce + (period if mode == PRODUCE else 0.0),
        watch.time_unload + (period if mode == UNLOAD else 0.0),
        watch.clipped,
    )


@inlined
def counted(watch: Watch, cg: float) -> Watch:
    """Count a wrapped law that asks for a negative generator gain `cg`: the motor is not its to use."""
    more = watch.clipped + (1.0 if cg < 0.0 else 0.0)
    return Watch(*(watch[:-1] + (more,)))  # noqa: RUF005 - numba knows the sum of tuples, not two stars


@inlined
def motor(rules: Rules, omega_rate: float) -> float:
    """Generator gain as a motor: negative where the flywheel turns the right way, a brake where the wrong one. [Nms]"""
    if omega_rate <= 0.0:
        return rules.motor_gain
    return -min(rules.motor_gain, rules.motor_power / (omega_rate * omega_rate))


@inlined
def command(rules: Rules, y: Any, watch: Watch, cc: float, cg: float) -> tuple[float, float]:
    """Command (cc, cg) [Nms] in the mode of `watch`, where the wrapped law wants `cc` and `cg`."""
    if watch.mode == START:
        return rules.cc_start, motor(rules, y.omega_rate)
    if watch.mode == PULL:
        missing = rules.top_ratio * rules.N * rules.wp - y.omega_rate
        hold = min(max(missing, 0.0), 1.0)  # all of the motor from 1 rad/s below on
        if watch.steady > 0.0:
            hold = 0.0
        return rules.cc_pull, hold * min(motor(rules, y.omega_rate), 0.0)
    if watch.mode == PRODUCE:
        if watch.share >= 1.0:
            return cc, max(cg, 0.0)
        return rules.cc_pull + watch.share * (cc - rules.cc_pull), watch.share * max(cg, 0.0)
    return rules.cc_pull, 0.0
