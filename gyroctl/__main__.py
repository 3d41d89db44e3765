"""Run the command line as ``python -m gyroctl``."""

from gyroctl.cli import main

if __name__ == "__main__":
    main()
