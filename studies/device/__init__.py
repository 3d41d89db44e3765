"""Whether a device of one's own can be: its inertias, frequencies, lock, and what its numbers assume."""

from gyroctl.studies.device.report import device_report

__all__ = ["device_report"]
