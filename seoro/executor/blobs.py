"""Contents of bundles, by their SHA-256: each is kept once, and is whole and what its name says, or not there."""

from __future__ import annotations

import hashlib
import os
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
from seoro.durable import sync_file
from seoro.executor.shares import Shares

PART: Final = ".part"  # ends the name of one that is not whole
ARRIVING: Final = 60.0  # [s] in which the next part of a blob comes
MEBIBYTE: Final = 1 << 20


class Blobs:
    """The blobs of an executor.

    Args:
        folder: Where they lie.
    """

    def __init__(self, folder: Path) -> None:
        self.folder: Final = folder
        self._shares = Shares()
        self._in_use = Counter[str]()  # by how many bundles that are being laid out
        self._doomed: set[str] = set()  # those of them that go then
        self._lock = threading.Lock()  # parts are put by threads

    def path(self, digest: str) -> Path:
        """The file of a blob, whether it is there or not."""
        return self.folder / digest

    def missing(self, digests: Iterable[str]) -> tuple[str, ...]:
        """Those that are not there."""
        return tuple(digest for digest in digests if not self.path(digest).is_file())

    def put(self, part: wire.PutBlob, kept: int = wire.MAX_BUNDLE) -> None:
        """Take a part; the last makes the blob whole. What is there already of a part stays as it is.

        So a part may come again whose answer was lost, and several may send the same blob at once.

        Args:
            part: The part.
            kept: How much is kept of its sender [bytes]; what they have used least recently goes.

        Raises:
            OSError: It cannot be written; of the blob, nothing stays.
            RequestRefused: Parts before it are missing, or the content is not what its name says, and the blob has
                to be sent anew (`INCORRECT_STATE`); or it is too large.
        """
        with self._lock:
            self._put(part, kept)

    def _put(self, part: wire.PutBlob, kept: int) -> None:
        final = self.path(part.hash)
        if final.is_file():
            return
        end = part.offset + len(part.data)
        if end > part.size:
            raise RequestRefused(Result.OPERATION_FAILED, "the blob is longer than it says")
        partial = final.with_suffix(PART)
        there = self._there(part, partial)
        if there is None:
            self._take_in(part, kept)
            there = 0
        elif end <= there:
            return
        try:
            with partial.open("r+b" if there else "wb") as file:
                file.seek(there)
                file.write(part.data[there - part.offset :])
        except OSError:  # a full disk, of which half a blob is to have nothing
            self._remove(part.hash)
            raise
        if end == part.size:
            self._complete(partial, final, part.hash)

    def _there(self, part: wire.PutBlob, partial: Path) -> int | None:
        """How much there is of the blob of a part [bytes]; None if the part begins it.

        The size that was said with the first part counts for its sender: parts that say another are of another
        upload.
        """
        there = partial.stat().st_size if partial.exists() else 0
        is_under_way = there > 0 and self._shares.said_size(part.hash) == part.size
        if part.offset == 0 and not is_under_way:
            return None
        if not is_under_way or part.offset > there:
            after = f"after {there}" if is_under_way else f"as nothing has come of {part.size} bytes"
            raise RequestRefused(Result.INCORRECT_STATE, f"the part at {part.offset} comes out of turn, {after}")
        return there

    def _take_in(self, part: wire.PutBlob, kept: int) -> None:
        """Have a blob that begins count for its sender, and drop of theirs what is too much then."""
        if part.size > kept:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"a file of {in_mebibytes(part.size)} cannot be taken: no more than {in_mebibytes(kept)} of files "
                "are kept of you",
            )
        self._shares.add(part.by, part.hash, part.size)
        while self._shares.size(part.by) > kept:
            self._remove(self._shares.oldest(part.by))

    def use(self, digests: Iterable[str]) -> None:
        """Note that blobs are in use, so that they are kept."""
        with self._lock:
            for digest in digests:
                os.utime(self.path(digest))
                self._shares.use(digest)

    @contextmanager
    def in_use(self, digests: Collection[str]) -> Iterator[None]:
        """Keep blobs while the block lasts; those that were to be dropped meanwhile go at its end."""
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
        """Remove those of some blobs that somebody has sent; whoever was to use them sends them again."""
        with self._lock:
            for digest in digests:
                if not self._shares.is_of(owner, digest):
                    continue
                if digest in self._in_use:
                    self._doomed.add(digest)
                else:
                    self._remove(digest)

    def forget(self, before: float) -> None:
        """Remove those that were used last before a time."""
        with self._lock:
            for path in self.folder.iterdir():
                if path.stat().st_mtime < before:
                    self._remove(path.stem)

    def drop_until(self, is_enough: Callable[[], bool], spared: Collection[str]) -> None:
        """Remove those that were used least recently, until that is enough, or there are no more.

        Args:
            is_enough: Asked after each.
            spared: Hashes of those that stay, as do those that are arriving.
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
        self._shares.drop(digest)

    def _complete(self, partial: Path, final: Path, digest: str) -> None:
        with partial.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
        if found != digest:
            self._remove(digest)
            # Another may have sent parts of it, which are not those of the last sender.
            raise RequestRefused(Result.INCORRECT_STATE, "the content of the blob is not what its name says")
        sync_file(partial)  # else, the name may outlast a loss of power without the content
        os.replace(partial, final)  # noqa: PTH105 - atomic, which is the point


def in_mebibytes(size: int) -> str:
    """A size, for people."""
    return f"{size / MEBIBYTE:.1f} MiB"


def _used(path: Path) -> float:
    """When a file was used last [s since 1970]; one that is gone was not."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0
