"""Memory and number of the processes of a run.

The limit of the kernel on address space (`RLIMIT_AS`) does not limit memory. It applies to each process alone, and
counts reserved but unused pages; simulators and Zenoh reserve gigabytes. So the used memory is measured
twice a second, with proportional shares of common pages (PSS, `proc_pid_smaps(5)`). A run that allocates gigabytes
between two measurements is not stopped in time.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from threading import Lock
from typing import Final

PERIOD: Final = 0.5  # [s] between two measurements
_PROC: Final = Path("/proc")


class Census:
    """Processes of the machine by their parents, cached for half a period."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._children: Mapping[int, list[int]] = {}
        self._taken = -PERIOD

    def family(self, process: int) -> tuple[int, ...]:
        """Return a process and its descendants."""
        with self._lock:
            if time.monotonic() - self._taken > PERIOD / 2:
                self._children = _children()
                self._taken = time.monotonic()
            children = self._children
        found = [process]
        for each in found:  # it grows
            found += children.get(each, ())
        return tuple(found)


def _children() -> dict[int, list[int]]:
    children: dict[int, list[int]] = {}
    for process in _processes():
        if (parent := _parent(_PROC / str(process))) is not None:
            children.setdefault(parent, []).append(process)
    return children


def _processes() -> Iterator[int]:
    return (int(path.name) for path in _PROC.iterdir() if path.name.isdecimal())


def used_by(family: tuple[int, ...]) -> int:
    """Return the memory of some processes together [MiB]."""
    return sum(map(_size, family)) // 1024


def _parent(path: Path) -> int | None:
    try:
        # The name of the program, in parentheses, may contain any characters.
        return int((path / "stat").read_text().rpartition(")")[2].split()[1])
    except (OSError, ValueError, IndexError):  # it has ended
        return None


def _size(process: int) -> int:
    """Return the memory of a process [KiB]."""
    try:
        text = (_PROC / str(process) / "smaps_rollup").read_text()
        return next(int(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:"))
    except (OSError, StopIteration):  # it has ended
        return 0
