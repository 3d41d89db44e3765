"""Ctrl-C ends a command within seconds, with what is finished kept."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from test_first_steps import LAWS

from gyroctl.comparison.processes import Processes, no_way_out


@pytest.mark.slow
def test_stopped_comparison_says_no_word_of_semaphores(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("[run]\nseeds = [1, 2, 3, 4, 5, 6]\n[laws.mine]\nlaw = 'laws.py:Slow'\n")
    slow = LAWS.replace("class Wild", "import time\n\n\nclass Slow").replace("def step(self", "def step(self", 1)
    slow = slow.replace("return (0.06, 4e-4), (", "time.sleep(2e-3)\n        return (0.06, 4e-4), (")
    (tmp_path / "laws.py").write_text(slow)
    command = [sys.executable, "-m", "gyroctl", "compare", "mine.toml", "--out", "out"]
    running = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    time.sleep(12.0)
    running.send_signal(signal.CTRL_C_EVENT if os.name == "nt" else signal.SIGINT)
    _, said = running.communicate(timeout=10.0)
    assert running.returncode == 130, said
    assert "Finished runs are kept" in said
    assert "leaked" not in said and "semaphore" not in said


STUBBORN = """
import threading, time
from gyroctl.cli import app, stopping

def swallowing():
    threading.Thread(target=time.sleep, args=(60.0,)).start()  # as a compilation would be waited for
    print("ready", flush=True)
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        try:
            time.sleep(0.1)
        except KeyboardInterrupt:  # as within the callback of a library
            pass

app.app = swallowing
app.main()
"""


COMPILING = """
import ctypes, time
from gyroctl.cli import app

def within():
    print("ready", flush=True)
    time.sleep(60.0)

def compiling():
    ctypes.CFUNCTYPE(None)(within)()  # what is raised in it is printed
    time.sleep(60.0)

app.app = compiling
app.main()
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="needs a signal to one process")
@pytest.mark.parametrize("program", [STUBBORN, COMPILING])
@pytest.mark.parametrize(("number", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_stop_is_heard_even_where_a_library_swallows_it(tmp_path: Path, number: str, code: int, program: str) -> None:
    pipe = subprocess.PIPE
    running = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stderr=pipe, stdout=pipe, text=True)
    assert running.stdout is not None and running.stdout.readline() == "ready\n"
    running.send_signal(signal.Signals[number])
    _, said = running.communicate(timeout=15.0)
    assert running.returncode == code
    assert said.strip() == "Stopped. Finished runs are kept and will not be computed again."


def in_a_callback() -> None:
    print("ready", flush=True)
    ctypes.CFUNCTYPE(None)(lambda: time.sleep(60.0))()
    print("went on", flush=True)


def compile_for_long() -> None:
    no_way_out(in_a_callback)


@pytest.mark.skipif(os.name == "nt", reason="needs a signal to one process")
def test_process_that_is_asked_to_end_in_a_callback_ends_without_a_word(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Of a pool, while its law is denied the way out."""
    processes = Processes(1)
    processes.schedule(compile_for_long, ())
    said = ""
    while "ready" not in said:
        time.sleep(0.1)
        said += capfd.readouterr().out
    processes.pool.stop()
    processes.pool.join()
    out, err = capfd.readouterr()
    assert "went on" not in out and err == ""
