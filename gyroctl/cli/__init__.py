"""The command line. Heavy modules are imported inside the commands, so that --help answers at once."""

from gyroctl.cli.stopping import end_soon_at_interrupt, stopped

__all__ = ["main"]


def main() -> None:
    """Run the command line; from here on it can be stopped without a word of where it was."""
    end_soon_at_interrupt()
    try:
        from gyroctl.cli.app import main as run
    except KeyboardInterrupt:
        stopped()
    run()
