"""Laws by rules: constant controls, load angle, fast coupling."""

from gyroctl.controllers.rule_based.constant import Constant, best_constant
from gyroctl.controllers.rule_based.coupling import Coupling
from gyroctl.controllers.rule_based.load_angle import LoadAngle
from gyroctl.controllers.rule_based.shipped import shipped, tuning_seeds

__all__ = ["Constant", "Coupling", "LoadAngle", "best_constant", "shipped", "tuning_seeds"]
