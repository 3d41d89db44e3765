"""Does the magnetic coupling help? The device with it against its rigidly geared predecessor, on identical waves.

``python -m gyroctl.studies.connection --seeds 1:65`` makes the table and the figure.
"""

from gyroctl.studies.connection.draw import draw
from gyroctl.studies.connection.report import answer_of, connection_report, table
from gyroctl.studies.connection.runs import Answer, AtBest, SameGain, compare_connections

__all__ = ["Answer", "AtBest", "SameGain", "answer_of", "compare_connections", "connection_report", "draw", "table"]
