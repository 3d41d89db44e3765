"""The plant: parameters, the one text of the equations (22)-(25), energy and kernel."""

from gyroctl.plant.parameters import Parameters
from gyroctl.plant.plant import Excitation, Plant
from gyroctl.plant.radiation import Radiation

__all__ = ["Excitation", "Parameters", "Plant", "Radiation"]
