"""Exit statuses of the command line."""

from __future__ import annotations

from enum import IntEnum

from seoro.runtime.verdict import RunStatus


class Exit(IntEnum):
    """What the exit status of a command says."""

    PASSED = 0
    FAILED = 1
    INVALID = 2  # the command line, or the scenario
    ERROR = 3  # no verdict could be reached
    CANCELLED = 4
    INTERRUPTED = 130  # by Ctrl-C


OF_STATUS = {
    RunStatus.PASSED: Exit.PASSED,
    RunStatus.FAILED: Exit.FAILED,
    RunStatus.ERROR: Exit.ERROR,
    RunStatus.CANCELLED: Exit.CANCELLED,
}
