"""Contents of bundles, by their SHA-256: each is kept once, and is whole and what its name says, or not there."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused


class Blobs:
    """The blobs of an executor.

    Args:
        folder: Where they lie.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def path(self, digest: str) -> Path:
        """The file of a blob, whether it is there or not."""
        return self._folder / digest

    def missing(self, digests: Iterable[str]) -> tuple[str, ...]:
        """Those that are not there."""
        return tuple(digest for digest in digests if not self.path(digest).is_file())

    def put(self, part: wire.PutBlob) -> None:
        """Take a part; the last makes the blob whole. A part that is there already changes nothing.

        Raises:
            OSError: It cannot be written; of the blob, nothing stays.
            RequestRefused: Parts before it are missing, or the content is not what its name says.
        """
        final = self.path(part.hash)
        if final.is_file():
            return
        partial = final.with_suffix(".part")
        there = partial.stat().st_size if partial.exists() else 0
        if part.offset == 0:
            there = 0
        elif part.offset != there:
            raise RequestRefused(
                Result.INCORRECT_STATE, f"the part at {part.offset} comes out of turn, after {there}"
            )
        if part.offset + len(part.data) > part.size:
            raise RequestRefused(Result.OPERATION_FAILED, "the blob is longer than it says")
        try:
            with partial.open("r+b" if there else "wb") as file:
                file.seek(part.offset)
                file.write(part.data)
        except OSError:  # a full disk, of which half a blob is to have nothing
            partial.unlink(missing_ok=True)
            raise
        if part.offset + len(part.data) == part.size:
            self._complete(partial, final, part.hash)

    def use(self, digests: Iterable[str]) -> None:
        """Note that blobs are in use, so that they are kept."""
        for digest in digests:
            os.utime(self.path(digest))

    def drop(self, digests: Iterable[str]) -> None:
        """Remove blobs; whoever was to use them sends them again."""
        for digest in digests:
            self.path(digest).unlink(missing_ok=True)

    def forget(self, before: float) -> None:
        """Remove those that were used last before a time."""
        for path in self._folder.iterdir():
            if path.stat().st_mtime < before:
                path.unlink(missing_ok=True)

    @staticmethod
    def _complete(partial: Path, final: Path, digest: str) -> None:
        with partial.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
        if found != digest:
            partial.unlink()
            raise RequestRefused(Result.OPERATION_FAILED, "the content of the blob is not what its name says")
        os.replace(partial, final)  # noqa: PTH105 - atomic, which is the point
