"""Repetition of a command whenever a file changes."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from seoro.cli.exit_status import Exit
from seoro.cli.packages import require

OPTION: Final = "--watch"
SUFFIXES: Final = (".osc", ".py", ".yaml", ".yml", ".toml", ".urdf", ".xml", ".sdf", ".lua")


def rerun_at_changes(arguments: Sequence[str], folder: Path) -> int:
    """Run a command of seoro, and again after each change of a file of tests, until Ctrl-C.

    Args:
        arguments: Command line with `--watch`, which each run omits.
        folder: Folder whose files are watched, without hidden folders and those of Python.

    Returns:
        The exit status of the last complete run.

    Raises:
        UsageError: The package watchfiles is missing.
    """
    require(f"`{OPTION}`", "test", "watchfiles")
    from watchfiles import DefaultFilter, watch  # noqa: PLC0415 - for this function only

    class OfTests(DefaultFilter):
        def __call__(self, change: object, path: str) -> bool:
            return path.endswith(SUFFIXES) and super().__call__(change, path)  # type: ignore[arg-type]

    command = [sys.executable, "-m", "seoro", *(each for each in arguments if each != OPTION)]
    status = Exit.PASSED
    try:
        status = Exit(subprocess.run(command, check=False).returncode)
        print(f"watching {folder}; Ctrl-C ends it", flush=True)
        for changes in watch(folder, watch_filter=OfTests()):
            changed = sorted({str(Path(path).relative_to(folder)) for _, path in changes})
            print(f"\nchanged: {', '.join(changed)}", flush=True)
            status = Exit(subprocess.run(command, check=False).returncode)
    except KeyboardInterrupt:
        pass
    return status
