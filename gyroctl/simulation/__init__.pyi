from .ensemble import EnsembleRun, run_ensemble
from .lock import cycle_slips, loss_time, wave_phasor
from .metrics import Record, evaluate
from .trajectory import trajectory

__all__ = ["EnsembleRun", "Record", "cycle_slips", "evaluate", "loss_time", "run_ensemble", "trajectory", "wave_phasor"]
