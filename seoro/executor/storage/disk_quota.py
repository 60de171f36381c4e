"""Disk quota of an executor: free space that runs and submissions must leave for the results of other runs."""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path
from typing import Final

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.limits import MEBIBYTE, Limits
from seoro.executor.storage.blobs import Blobs, in_mebibytes

FLOOR: Final = 1 << 30  # [bytes] that stay free by default,
PART: Final = 20  # or this fraction of the disk (1/PART), if that is less


def make_room(blobs: Blobs, folder: Path, size: int, limits: Limits, spared: Collection[str]) -> None:
    """Drop the least recently used blobs, if the disk has too little free space.

    Args:
        blobs: The blobs.
        folder: Folder on the disk.
        size: Required space [bytes].
        limits: Limits of the client.
        spared: Hashes of blobs that must stay.

    Raises:
        RequestRefused: The disk would still have too little free space.
    """
    floor = reserve_of(folder, limits)

    def is_enough() -> bool:
        return shutil.disk_usage(folder).free - size >= floor

    if is_enough():
        return
    blobs.drop_until(is_enough, spared)
    if not is_enough():
        free = shutil.disk_usage(folder).free
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the executor cannot store {in_mebibytes(size)}: its disk has {in_mebibytes(free)} left, of which "
            f"{in_mebibytes(floor)} stay free; remove old runs by `seoro rm`",
        )


def reserve_of(folder: Path, limits: Limits) -> int:
    """Return the disk space that runs and submissions must leave free [bytes]."""
    if limits.free is not None:
        return limits.free * MEBIBYTE
    return min(FLOOR, shutil.disk_usage(folder).total // PART)
