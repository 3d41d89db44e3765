"""How far ahead the wave moments can be foreseen, from ideal signals and from the sensors."""

from gyroctl.studies.forecast.report import forecast_report

__all__ = ["forecast_report"]
