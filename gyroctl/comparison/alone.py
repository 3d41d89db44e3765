"""Runs in a process beside a worker of a cluster: python -m gyroctl.comparison.alone, asked and told by its pipes.

A worker of a cluster may have no child of its own that shares its memory; a program of its own it may start. One serves
for many runs, as starting it takes seconds, and ends with its worker, after a while without work, or with the run that
brings it down.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import threading
from typing import IO, Any

import cloudpickle

from gyroctl.comparison.execution import GRACE, perform_sent
from gyroctl.comparison.items import Outcome, failed
from gyroctl.comparison.parcels import Parcel
from gyroctl.comparison.processes import KILLED_AGAIN, KILLS, how_it_ended
from gyroctl.engine.memory import as_usual

IDLE = 60.0
"""After which a process without work is ended. [s]"""

SIZE = struct.Struct("<Q")

_lock = threading.Lock()
_idle: list[_Process] = []


def in_a_process(parcel: Parcel) -> list[Outcome]:
    """Run an item whose law is packed; one that takes too long is ended, and whatever it does its run fails alone.

    One whose process was killed is run again, as on a machine of its own.
    """
    for last in (*[False] * KILLED_AGAIN, True):
        with _lock:
            process = _idle.pop() if _idle else None
        process = process or _Process()
        outcomes = process.run(parcel)
        if process.lives():
            with _lock:
                _idle.append(process)
            process.end_if_idle()
        if last or not process.was_killed():
            break
    return outcomes


class _Process:
    """A process that runs items one after the other."""

    def __init__(self) -> None:
        command, pipe = [sys.executable, "-m", __name__], subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, env=as_usual(os.environ))
        self.late, self.clock = False, threading.Timer(0.0, self.end)

    def run(self, parcel: Parcel) -> list[Outcome]:
        """Run an item, and end the process where that takes too long."""
        item = parcel.item
        self.clock.cancel()
        self.late, self.clock = False, threading.Timer(item.time_limit + GRACE, self._too_late)
        self.clock.daemon = True
        self.clock.start()
        assert self.process.stdin is not None and self.process.stdout is not None
        try:
            _send(self.process.stdin, parcel)
            found: list[Outcome] = _receive(self.process.stdout)
        except (EOFError, OSError):
            code = self.process.wait()
            what = f"took longer than {item.time_limit:g} s: compute less in step, or allow more with run.time_limit"
            return [failed(item, f"law {item.name!r} {what if self.late else how_it_ended(code)}")]
        finally:
            self.clock.cancel()
        return found

    def _too_late(self) -> None:
        self.late = True
        self.process.kill()

    def was_killed(self) -> bool:
        """Whether others have ended it, and not for its time."""
        return not self.late and -(self.process.poll() or 0) in KILLS

    def lives(self) -> bool:
        """Whether it can be given more work."""
        return self.process.poll() is None

    def end_if_idle(self) -> None:
        """End it after a while, unless it is given work before."""
        self.clock = threading.Timer(IDLE, self._end_idle)
        self.clock.daemon = True
        self.clock.start()

    def _end_idle(self) -> None:
        with _lock:
            if self not in _idle:
                return
            _idle.remove(self)
        self.end()

    def end(self) -> None:
        """End it."""
        self.process.kill()
        self.process.wait()


def _send(stream: IO[bytes], what: Any) -> None:
    packed = cloudpickle.dumps(what)
    stream.write(SIZE.pack(len(packed)) + packed)
    stream.flush()


def _receive(stream: IO[bytes]) -> Any:
    """What comes next.

    Raises
    ------
    EOFError
        Where the other side has ended.
    """
    size = stream.read(SIZE.size)
    if len(size) < SIZE.size:
        raise EOFError
    packed = stream.read(SIZE.unpack(size)[0])
    if len(packed) < SIZE.unpack(size)[0]:
        raise EOFError
    return cloudpickle.loads(packed)


def main() -> None:
    """Run what is asked by the first pipe, and tell it by the second one, which no law gets to see."""
    asked, told = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    try:
        while True:
            _send(told, perform_sent(_receive(asked)))
    except (EOFError, OSError):  # its worker has ended
        os._exit(0)


if __name__ == "__main__":
    main()
