"""Every process of Python that finds this folder first notes each run that it begins and ends, in a journal.

The journal only grows, a line at a time: it is independent of the store, of the driver and of whatever dies. What a
result is known by is the hash of files, and not changed by this.
"""

import os
import sys
import time
from importlib.abc import MetaPathFinder
from importlib.util import find_spec

WATCHED = "gyroctl.comparison.items"


def note(word, items):
    """Add a line for each item in one write: to a file that is open to append, it stands whole."""
    now = time.time_ns()
    text = "".join(f"{word} {item.key} {now} {os.getpid()}\n" for item in items)
    handle = os.open(os.environ["KILLS_JOURNAL"], os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    try:
        os.write(handle, text.encode())
    finally:
        os.close(handle)


class Watching(MetaPathFinder):
    """Wraps what performs items as soon as its module has been loaded."""

    def find_spec(self, name, path=None, target=None):
        if name != WATCHED or self not in sys.meta_path:
            return None
        sys.meta_path.remove(self)
        spec = find_spec(name)
        load = spec.loader.exec_module

        def loaded(module):
            load(module)
            perform = module.perform

            def noted(items):
                note("begin", items)
                outcomes = perform(items)
                note("end", items)
                return outcomes

            module.perform = noted

        spec.loader.exec_module = loaded
        return spec


if "KILLS_JOURNAL" in os.environ:
    sys.meta_path.insert(0, Watching())
