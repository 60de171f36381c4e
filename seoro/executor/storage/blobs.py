"""Blobs: files of bundles by their SHA-256. Each is stored once, complete and verified.

Runs and submissions must leave free space on the disk for the results of other runs.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import threading
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.limits import MEBIBYTE, Limits
from seoro.executor.storage.blob_quota import BlobQuota
from seoro.files.durable import sync_file

PART: Final = ".part"  # suffix of an incomplete blob
ARRIVING: Final = 60.0  # [s] between two parts of a blob that is being sent
FLOOR: Final = 1 << 30  # [bytes] of the disk that stay free by default,
SHARE: Final = 20  # or this fraction of the disk (1/SHARE), if that is less


class Blobs:
    """The blobs of an executor.

    Args:
        folder: Folder of the blobs.
    """

    def __init__(self, folder: Path) -> None:
        self.folder: Final = folder
        self._quota = BlobQuota()
        self._in_use = Counter[str]()  # number of bundles that are being unpacked, by blob
        self._doomed: set[str] = set()  # blobs in use that are removed afterwards
        self._lock = threading.Lock()  # parts are stored by threads

    def path(self, digest: str) -> Path:
        """Return the path of a blob, which may be missing."""
        return self.folder / digest

    def missing(self, digests: Iterable[str]) -> tuple[str, ...]:
        """Return the hashes of missing blobs."""
        return tuple(digest for digest in digests if not self.path(digest).is_file())

    def put(self, part: wire.PutBlob, kept: int = wire.MAX_BUNDLE) -> None:
        """Store a part; the last one completes the blob. Bytes that are stored already stay as they are.

        So a part whose answer was lost may be sent again, and several clients may send the same blob at once.

        Args:
            part: The part.
            kept: Quota of the sender [bytes]; its least recently used blobs are dropped.

        Raises:
            OSError: The part cannot be written; the incomplete blob is removed.
            RequestRefused: Earlier parts are missing or the hash is wrong, so that the blob has to be sent again
                (`INCORRECT_STATE`); or the blob is too large.
        """
        with self._lock:
            self._put(part, kept)

    def _put(self, part: wire.PutBlob, kept: int) -> None:
        final = self.path(part.hash)
        if final.is_file():
            return
        end = part.offset + len(part.data)
        if end > part.size:
            raise RequestRefused(Result.OPERATION_FAILED, "the blob is longer than announced")
        partial = final.with_suffix(PART)
        there = self._stored_size(part, partial)
        if there is None:
            self._begin(part, kept)
            there = 0
        elif end <= there:
            return
        try:
            with partial.open("r+b" if there else "wb") as file:
                file.seek(there)
                file.write(part.data[there - part.offset :])
        except OSError:  # full disk: free the space of the incomplete blob
            self._remove(part.hash)
            raise
        if end == part.size:
            self._complete(partial, final, part.hash)

    def _stored_size(self, part: wire.PutBlob, partial: Path) -> int | None:
        """Return the stored size of the blob of a part [bytes]; None if the part begins it.

        A part with another size than the first one belongs to another upload.
        """
        there = partial.stat().st_size if partial.exists() else 0
        is_under_way = there > 0 and self._quota.announced_size(part.hash) == part.size
        if part.offset == 0 and not is_under_way:
            return None
        if not is_under_way or part.offset > there:
            expected = there if is_under_way else 0
            raise RequestRefused(
                Result.INCORRECT_STATE, f"part of a blob at byte {part.offset}; expected byte {expected}"
            )
        return there

    def _begin(self, part: wire.PutBlob, kept: int) -> None:
        """Assign a new blob to its sender, and drop the sender's oldest blobs beyond the quota."""
        if part.size > kept:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"a file of {in_mebibytes(part.size)} exceeds your quota of {in_mebibytes(kept)} (`kept` in the "
                "policy of the executor)",
            )
        self._quota.add(part.by, part.hash, part.size)
        while self._quota.size(part.by) > kept:
            self._remove(self._quota.oldest(part.by))

    def use(self, digests: Iterable[str]) -> None:
        """Mark blobs as used now, so that they are kept."""
        with self._lock:
            for digest in digests:
                os.utime(self.path(digest))
                self._quota.use(digest)

    @contextmanager
    def in_use(self, digests: Collection[str]) -> Iterator[None]:
        """Keep blobs while the block lasts; dropped ones are removed at its end."""
        with self._lock:
            self._in_use.update(digests)
        try:
            yield
        finally:
            with self._lock:
                self._in_use.subtract(digests)
                for digest in digests:
                    if self._in_use[digest] == 0:
                        del self._in_use[digest]
                        if digest in self._doomed:
                            self._doomed.discard(digest)
                            self._remove(digest)

    def drop(self, digests: Iterable[str], owner: str) -> None:
        """Remove those of some blobs that belong to an owner."""
        with self._lock:
            for digest in digests:
                if not self._quota.is_owned_by(owner, digest):
                    continue
                if digest in self._in_use:
                    self._doomed.add(digest)
                else:
                    self._remove(digest)

    def remove_old(self, before: float) -> None:
        """Remove blobs that were last used before a time."""
        with self._lock:
            for path in self.folder.iterdir():
                if path.stat().st_mtime < before:
                    self._remove(path.stem)

    def drop_until(self, is_enough: Callable[[], bool], spared: Collection[str]) -> None:
        """Remove the least recently used blobs until `is_enough`, or none is left.

        Args:
            is_enough: Called before each removal.
            spared: Hashes of blobs that stay, as do those in use or being sent.
        """
        with self._lock:
            arriving = time.time() - ARRIVING
            for path in sorted(self.folder.iterdir(), key=_used):
                if is_enough():
                    return
                if (
                    path.stem not in spared
                    and path.stem not in self._in_use
                    and (path.suffix != PART or _used(path) < arriving)
                ):
                    self._remove(path.stem)

    def _remove(self, digest: str) -> None:
        for path in (self.path(digest), self.path(digest).with_suffix(PART)):
            path.unlink(missing_ok=True)
        self._quota.drop(digest)

    def _complete(self, partial: Path, final: Path, digest: str) -> None:
        with partial.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
        if found != digest:
            self._remove(digest)
            # Another client may have sent wrong parts of it.
            raise RequestRefused(Result.INCORRECT_STATE, "the content of the blob does not match its hash")
        sync_file(partial)  # else the name may survive a loss of power without the content
        os.replace(partial, final)  # noqa: PTH105 - atomic


def in_mebibytes(size: int) -> str:
    """Format a size [bytes] in MiB."""
    return f"{size / MEBIBYTE:.1f} MiB"


def _used(path: Path) -> float:
    """Return the time of the last use of a file [s since 1970]; 0 for a removed one."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0


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
    return min(FLOOR, shutil.disk_usage(folder).total // SHARE)
