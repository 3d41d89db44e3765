"""What runs long and keeps what is finished: work items, each known by all that can change a bit of its result."""

from gyroctl.engine.record import Record
from gyroctl.engine.store import Store

__all__ = ["Record", "Store"]
