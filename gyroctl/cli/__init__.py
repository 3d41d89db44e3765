"""The command line. Heavy modules are imported inside the commands, so that --help answers at once."""

from gyroctl.cli.app import main

__all__ = ["main"]
