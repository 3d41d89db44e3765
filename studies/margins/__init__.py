"""Margins of a lock: how far the load, the wave and the state may move before it breaks, in numbers and pictures."""

from gyroctl.studies.margins.report import lock_map_report, margin_report
from gyroctl.studies.margins.request import Request, find_orbit, request
from gyroctl.studies.margins.result import MarginResult, margins

__all__ = ["MarginResult", "Request", "find_orbit", "lock_map_report", "margin_report", "margins", "request"]
