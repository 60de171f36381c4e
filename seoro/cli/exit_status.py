"""Exit statuses of the command line."""

from __future__ import annotations

from enum import IntEnum

from seoro.runtime.verdict import RunStatus


class Exit(IntEnum):
    """Exit status of a command."""

    PASSED = 0
    FAILED = 1
    INVALID = 2  # invalid command line or scenario
    ERROR = 3  # no verdict
    CANCELLED = 4
    INTERRUPTED = 130  # by Ctrl-C


OF_STATUS = {
    RunStatus.PASSED: Exit.PASSED,
    RunStatus.FAILED: Exit.FAILED,
    RunStatus.ERROR: Exit.ERROR,
    RunStatus.CANCELLED: Exit.CANCELLED,
}
