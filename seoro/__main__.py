"""`python -m seoro`: the command line of the installation of this Python."""

import sys

from seoro.cli.main import run_process

if __name__ == "__main__":
    sys.exit(run_process())
