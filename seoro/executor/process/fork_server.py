"""Fork server for runs: `python -m seoro.executor.process.fork_server REQUESTS REPORTS`, two socket descriptors.

It loads all modules for runs once (see `seoro.concurrency.forks`), and runs no scenarios of users.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from seoro.concurrency.forks.serving import serve_forks
from seoro.embed import check_file
from seoro.embed import run as run_scenario
from seoro.executor.process.worker import work
from seoro.executor.sandbox.command import visible_folders
from seoro.lang.loader import read_file

_WARM_UP: Final = """import osc.helpers
scenario warm_up:
    do serial:
        log("ready")
        wait elapsed(1s)
"""


def main(arguments: Sequence[str]) -> None:
    """Fork processes until the executor ends."""
    requests, reports = map(int, arguments)
    _warm_up()
    pipes = serve_forks(requests, reports)
    if pipes is not None:
        work(*pipes)


def _warm_up() -> None:
    """Run a small scenario to load modules that are imported on demand, and find the folders for sandboxes."""
    visible_folders()
    path = Path("warm_up.osc")
    scenario = check_file(path, read=lambda other: _WARM_UP if other == path else read_file(other))
    run_scenario(scenario, clock="virtual", seed=0)


if __name__ == "__main__":
    main(sys.argv[1:])
