"""The supervisor: start-up from rest, unloading and re-lock around any law."""

from gyroctl.controllers.supervisor.rules import MODES, Rules, Watch
from gyroctl.controllers.supervisor.wrap import Supervisor, supervisor, wrap

__all__ = ["MODES", "Rules", "Supervisor", "Watch", "supervisor", "wrap"]
