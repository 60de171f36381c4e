"""How much memory the processes of a run have, so that one with too much can be ended.

A limit of the kernel on address space (`RLIMIT_AS`) is no measure of that: it is for each process alone, where a
run has several, and counts what is reserved and never used, which simulators and Zenoh have by the gigabyte. So
what is used is looked at, twice a second: what is shared with other processes counts in parts (PSS,
`proc_pid_smaps(5)`). A run that takes gigabytes between two looks is not caught in time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Final

PERIOD: Final = 0.5  # [s]
_PROC: Final = Path("/proc")


async def exceeds(process: int, limit: int) -> int:
    """Wait until a process and those below it have more memory than a limit; returns how much, in MiB.

    Args:
        process: Its number.
        limit: [MiB].
    """
    while True:
        await asyncio.sleep(PERIOD)
        used = await asyncio.to_thread(used_by, process)
        if used > limit:
            return used


def used_by(process: int) -> int:
    """Memory of a process and all below it [MiB]."""
    return sum(map(_size, _family(process))) // 1024


def _family(process: int) -> Iterator[int]:
    """A process and all below it."""
    children: dict[int, list[int]] = {}
    for path in _PROC.iterdir():
        if path.name.isdecimal() and (parent := _parent(path)) is not None:
            children.setdefault(parent, []).append(int(path.name))
    found = [process]
    while found:
        each = found.pop()
        yield each
        found += children.get(each, [])


def _parent(path: Path) -> int | None:
    try:
        # Beside its number, the name of the program, in which there may be anything, stands in parentheses.
        return int((path / "stat").read_text().rpartition(")")[2].split()[1])
    except (OSError, ValueError, IndexError):  # it has ended
        return None


def _size(process: int) -> int:
    """[KiB]."""
    try:
        text = (_PROC / str(process) / "smaps_rollup").read_text()
        return next(int(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:"))
    except (OSError, StopIteration):  # it has ended
        return 0
