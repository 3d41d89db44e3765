"""Laws by rules: constant, threshold, load angle, libration stabiliser, frequency tracking, fast coupling."""

from gyroctl.controllers.rule_based.constant import Constant, best_constant
from gyroctl.controllers.rule_based.coupling import Coupling
from gyroctl.controllers.rule_based.load_angle import LoadAngle
from gyroctl.controllers.rule_based.shipped import shipped
from gyroctl.controllers.rule_based.stabiliser import Stabiliser
from gyroctl.controllers.rule_based.threshold import Threshold
from gyroctl.controllers.rule_based.tracking import Tracking

__all__ = ["Constant", "Coupling", "LoadAngle", "Stabiliser", "Threshold", "Tracking", "best_constant", "shipped"]
