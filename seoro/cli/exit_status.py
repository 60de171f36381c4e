"""Exit statuses of the command line."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from seoro.runtime.verdict import RunStatus


class Exit(IntEnum):
    """Exit status of a command."""

    PASSED = 0
    FAILED = 1
    INVALID = 2  # invalid command line or scenario
    ERROR = 3  # no verdict
    CANCELLED = 4
    INTERRUPTED = 130  # by Ctrl-C

    @classmethod
    def of_run(cls, status: RunStatus) -> Exit:
        """Return the exit status for the status of a run; both have the same names."""
        return cls[status.name]
