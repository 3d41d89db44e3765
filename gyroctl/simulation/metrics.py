"""What one run is worth: power and its smoothness, lock, motion, energy ledger. Each definition stands here once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PHI1, PHI3, PSI
from gyroctl.simulation.balance import electrical, spent
from gyroctl.simulation.lock import THRESHOLD, WINDOW, loss_time, phase_of_moment

MODEL_LIMIT = 0.3
"""Float motion beyond which the equations, linear in phi, are outside their range. [rad]"""

UNITS = {
    "mean_power": "W",
    "generated_w": "W",
    "stored_w": "W",
    "power_cv": "1",
    "p98_over_mean": "1",
    "power_cv_1s": "1",
    "locked": "1",
    "loss_time": "s",
    "cycle_slips": "1 per 1000 waves",
    "waves_counted": "1",
    "turns_kept": "1",
    "phi1_p98": "rad",
    "phi3_p98": "rad",
    "phi1_max": "rad",
    "phi3_max": "rad",
    "outside_model": "1",
    "outside_share": "1",
    "wave_input_w": "W",
    "radiated_w": "W",
    "hinge_w": "W",
    "slip_loss_w": "W",
    "ledger_residual": "1",
    "capture_width_ratio": "1",
    "availability": "1",
    "motor_energy": "J",
    "net_energy": "J",
    "lock_begins": "s",
    "payback_time": "s",
}


@dataclass(frozen=True)
class Record:
    """One run, sampled at the period of the controls.

    Parameters
    ----------
    states : (n + 1, rows) array
        State and energy ledger at each sample. [rad], [rad/s], [J]
    commands, controls : (n, 2) arrays
        cc, cg as asked for at each sample and as they act from it on: held to the next, or where they move. [Nms]
    period : float
        Spacing of the samples. [s]
    saturations : int
        Commands beyond the limits.
    moved : (n, 3) array, optional
        Where controls move between the samples: cc, cg at the end of each interval, and the root of the mean square of
        cg over it. [Nms]
    lag : float
        Time constant with which the coupling moves between the samples. [s]
    """

    states: NDArray[np.float64]
    commands: NDArray[np.float64]
    controls: NDArray[np.float64]
    period: float
    saturations: int
    moved: NDArray[np.float64] | None = None
    lag: float = 0.0

    @property
    def ends(self) -> NDArray[np.float64]:
        """cc, cg at the end of each interval, (n, 2). [Nms]"""
        return self.controls if self.moved is None else self.moved[:, :2]

    @property
    def cg_rms(self) -> NDArray[np.float64]:
        """Root of the mean square of cg over each interval, (n,). [Nms]"""
        return self.controls[:, 1] if self.moved is None else self.moved[:, 2]


def evaluate(
    plant: Plant,
    record: Record,
    moment: NDArray[np.float64],
    moment_dt: float,
    wp: float,
    score_from: float,
    available: float,
    sense: int = 1,
    from_rest: bool = False,
) -> dict[str, float]:
    """Metrics of a run.

    Parameters
    ----------
    plant : Plant
        The device.
    record : Record
        The run.
    moment : (m,) array
        Me3 on its grid, for the phase of the waves. [Nm]
    moment_dt : float
        Its spacing. [s]
    wp : float
        Peak angular frequency. [rad/s]
    score_from : float
        Start of the scoring, the end of the blend. [s]
    available : float
        Wave power over the width of the float [W]; NaN where it is not defined.
    sense : {1, -1}
        Sense of rotation.
    from_rest : bool
        The run began at rest: lock can be lost only after it has begun.

    Returns
    -------
    dict
        By the names of `UNITS`. Powers are means over the scored time from the integrated ledger; the ledger's
        residual is over the whole run, relative to the wave input.

        `mean_power` is the power that is judged: the generated energy and the change of what flywheel and float store,
        over the scored time; `generated_w` and `stored_w` are its two parts. So nothing is won by draining a store in
        the end. The generated part is net: what the generator took as a motor is paid for. CV and 98 % are those of
        the electrical power. `locked` is NaN where the scored time is shorter than the 10 s by which lock is judged.
    """
    n = len(plant.labels)
    period, states = record.period, record.states
    pace = plant.parameters.time_scale  # lock is judged in the device's own time: ten seconds at the size of Table 1
    beat, turning = period / pace, wp * pace
    first = round(score_from / period)
    worth = plant.parameters.generator_efficiency
    psi, net = states[:, PSI], electrical(states[:, n + LEDGER.index("generator")], worth)
    in_production = production(psi, net, beat, turning, sense)
    begins = float(np.argmax(in_production)) * period if np.any(in_production) else np.nan
    if from_rest and np.isfinite(begins):
        lost = pace * float(loss_time(psi[round(begins / period) :], beat, turning, sense)) + begins
    else:
        lost = pace * float(loss_time(psi, beat, turning, sense))

    scored = (states.shape[0] - 1 - first) * period
    energy = dict(zip(plant.ledger, states[-1, n:] - states[first, n:], strict=True))
    whole = dict(zip(plant.ledger, states[-1, n:], strict=True))
    stored = plant.stored_energy(states[[0, first, -1], :n].T)
    taken = spent(whole) + stored[2] - stored[0]
    given = float(net[-1] - net[first])
    generated, gained = given / scored, worth * float(stored[2] - stored[1]) / scored
    judged = generated + gained

    speed, cg = states[first:, OMEGA_RATE], worth * record.cg_rms[first:]
    begin, end = cg * speed[:-1] ** 2, cg * speed[1:] ** 2  # cg jumps at the samples: both ends of each interval
    power = worth * record.controls[first:, 1] * speed[:-1] ** 2
    second = 0.5 * float(np.mean(begin**2) + np.mean(end**2))
    per_second = round(1.0 / beat)
    mean_1s = np.diff(net[first::per_second]) / (per_second * period)
    negative = np.flatnonzero(net < 0.0)
    repaid = negative[-1] + 1 if negative.size else 0
    phi1, phi3 = np.abs(states[first:, PHI1]), np.abs(states[first:, PHI3])
    held = round(begins / period) if from_rest and np.isfinite(begins) else first  # turns count once lock has begun
    phase = phase_of_moment(moment, moment_dt / pace, turning, held, states.shape[0], beat)
    waves = (states.shape[0] - 1 - held) * period * wp / (2.0 * np.pi)
    return {
        "mean_power": judged,
        "generated_w": generated,
        "stored_w": gained,
        "power_cv": float(np.sqrt(max(second - generated**2, 0.0)) / generated) if generated > 0 else np.nan,
        "p98_over_mean": float(np.quantile(power, 0.98) / generated) if generated > 0 else np.nan,
        "power_cv_1s": float(np.std(mean_1s) / generated) if generated > 0 else np.nan,
        "locked": float(np.isnan(lost)) if can_judge(scored / pace) else np.nan,
        "loss_time": lost,
        "cycle_slips": 1000.0 * phase.slips(psi[held:], sense) / waves,
        "waves_counted": waves,
        "turns_kept": phase.turns(psi[held:], sense),
        "phi1_p98": float(np.quantile(phi1, 0.98)),
        "phi3_p98": float(np.quantile(phi3, 0.98)),
        "phi1_max": float(phi1.max()),
        "phi3_max": float(phi3.max()),
        "outside_model": float(max(phi1.max(), phi3.max()) > MODEL_LIMIT),
        "outside_share": float(np.mean(np.maximum(phi1, phi3) > MODEL_LIMIT)),
        "wave_input_w": energy["wave_input"] / scored,
        "radiated_w": energy["radiated"] / scored,
        "hinge_w": energy["hinge"] / scored,
        "slip_loss_w": energy["slip"] / scored,
        "ledger_residual": float(abs(whole["wave_input"] - taken) / abs(whole["wave_input"])),
        "capture_width_ratio": judged / available,
        "availability": float(np.mean(in_production[max(first, round(WINDOW / beat)) :])),
        "motor_energy": float(np.sum(np.maximum(-np.diff(net[first:]), 0.0))),
        "net_energy": given,
        "lock_begins": begins,
        "payback_time": repaid * period if repaid < net.size else np.nan,
    }


def can_judge(scored: float) -> bool:
    """Whether a scored time [s] is as long as the mean by which lock is judged."""
    return scored >= WINDOW - 1e-6


def production(
    psi: NDArray[np.float64], net: NDArray[np.float64], period: float, wp: float, sense: int = 1
) -> NDArray[np.bool_]:
    """Tell when the device is in locked production: it keeps its turns by itself, without a motor.

    Parameters
    ----------
    psi : (n,) array
        Ring angle. [rad]
    net : (n,) array
        Energy of the generator so far, less that of the motor. [J]
    period : float
        Spacing of the samples. [s]
    wp : float
        Peak angular frequency. [rad/s]
    sense : {1, -1}
        Sense of rotation.

    Returns
    -------
    (n,) array of bool
        Whether over the last 10 s the mean ring speed was at least half of wp and the generator never a motor. False
        during the first 10 s.
    """
    span, found = round(WINDOW / period), np.zeros(psi.size, np.bool_)
    motored = np.concatenate([[0], np.cumsum(np.diff(net) < 0.0)])
    with np.errstate(invalid="ignore"):
        turning = sense * (psi[span:] - psi[:-span]) >= THRESHOLD * wp * WINDOW
    found[span:] = turning & (motored[span:] == motored[:-span])
    return found
