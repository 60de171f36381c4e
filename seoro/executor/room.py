"""Room on the disk of an executor: below a floor, nothing more is taken, so that runs can go on and be told of."""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path
from typing import Final

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.blobs import Blobs, in_mebibytes
from seoro.executor.limits import MEBIBYTE, Limits

FLOOR: Final = 1 << 30  # [bytes] that stay free, where nobody says otherwise,
PART: Final = 20  # or one of so many parts of the disk, if that is less


def make_room(blobs: Blobs, folder: Path, size: int, limits: Limits, spared: Collection[str]) -> None:
    """Drop blobs that were not used for long, if something would have no room else.

    Args:
        blobs: The blobs.
        folder: On the disk.
        size: Of what is to be taken [bytes].
        limits: Of who sends it.
        spared: Hashes of blobs that are needed for it.

    Raises:
        RequestRefused: Not so much would stay free as has to.
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
            f"the executor takes nothing of {in_mebibytes(size)} now: its disk has {in_mebibytes(free)} left, of "
            f"which {in_mebibytes(floor)} stay free; `seoro rm` forgets runs",
        )


def reserve_of(folder: Path, limits: Limits) -> int:
    """Bytes of the disk of a folder that runs and submissions must leave free."""
    if limits.free is not None:
        return limits.free * MEBIBYTE
    return min(FLOOR, shutil.disk_usage(folder).total // PART)
