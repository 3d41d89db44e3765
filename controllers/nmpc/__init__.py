"""Nonlinear model predictive control: plan the coupling over the waves to come, let the generator go steadily."""

from __future__ import annotations

from gyroctl.controllers.nmpc.law import Nmpc

__all__ = ["Nmpc"]
