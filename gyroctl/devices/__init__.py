"""Devices: that of the paper in its variants, one of your own from a file, the same at another size."""

from gyroctl.devices.file import device
from gyroctl.devices.zhang import VARIANTS, zhang2017

__all__ = ["VARIANTS", "device", "zhang2017"]
