"""Simulation: lock, metrics, trajectories and the compiled ensemble."""

from gyroctl.simulation.ensemble import EnsembleRun, run_ensemble
from gyroctl.simulation.lock import cycle_slips, loss_time, wave_phasor
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.simulation.trajectory import trajectory

__all__ = ["EnsembleRun", "Record", "cycle_slips", "evaluate", "loss_time", "run_ensemble", "trajectory", "wave_phasor"]
