"""The command line called in this process, and what the tests hand to it: an experiment, laws of users."""

from __future__ import annotations

from collections.abc import Callable

Run = Callable[..., tuple[int, str, str]]

SHORT = """
[run]
duration = 200
blend = 50
seeds = [1, 2]

[laws.steady]
law = "constant"
cc = 0.06

[laws.load_angle]
"""

LAWS_OF_USERS = """
class Base:
    period, information = 0.1, "none"
    def init(self): return None

class NotANumber(Base):
    def step(self, t, y, state): return (0.05, float("nan")), None

class WrongShape(Base):
    def step(self, t, y, state): return (0.05, 1e-4, 3.0), None

class Failing(Base):
    def step(self, t, y, state): return (1.0 / 0.0, 1e-4), None
"""
