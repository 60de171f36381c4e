"""State of a process of this machine, from `/proc/PID/stat`."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from pathlib import Path
from typing import Final

_TICKS: Final = os.sysconf("SC_CLK_TCK")  # [1/s] of processor time
_STATE, _FLAGS, _USER_TIME, _SYSTEM_TIME, _PENDING = 0, 6, 11, 12, 28  # positions behind the name (proc(5))
_EXITING: Final = 0x4  # PF_EXITING
_KILLED: Final = 1 << (signal.SIGKILL - 1)


def processor_time(process: int | None) -> float | None:
    """Return the processor time of a process so far [s]; None unless it lives.

    A killed process closes its connections before it is gone, which takes seconds on busy machines. So a process
    that is about to die counts as dead.

    Args:
        process: Process id; None for no process.
    """
    if process is None:
        return None
    try:
        text = Path(f"/proc/{process}/stat").read_text(encoding="ascii")
    except OSError:
        return None
    fields = text.rpartition(")")[2].split()
    if is_dying(fields):
        return None
    return (int(fields[_USER_TIME]) + int(fields[_SYSTEM_TIME])) / _TICKS


def is_dying(fields: Sequence[str]) -> bool:
    """Return whether a process has died, or is about to.

    Args:
        fields: Fields of its `stat` behind its name.
    """
    is_ending = fields[_STATE] in "ZX" or int(fields[_FLAGS]) & _EXITING
    return bool(is_ending or int(fields[_PENDING]) & _KILLED)
