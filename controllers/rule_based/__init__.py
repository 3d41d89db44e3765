"""Laws by rules: constant controls, load angle, fast coupling."""

from gyroctl.controllers.rule_based.constant import Constant, best_constant
from gyroctl.controllers.rule_based.coupling import Coupling
from gyroctl.controllers.rule_based.load_angle import LoadAngle

__all__ = ["Constant", "Coupling", "LoadAngle", "best_constant"]
