"""Bundles are laid out in the folders of their runs, and are on the disk before their runs are acknowledged.

Laying out a large bundle takes seconds: others submit meanwhile.
"""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from typing import Final

import anyio
import anyio.to_thread

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bundle.unpack import InvalidBundle, check_manifest, unpack
from seoro.executor.limits import Limits
from seoro.executor.storage.blobs import Blobs, make_room
from seoro.executor.storage.run_folder import RunFolder
from seoro.files.durable import sync_folder, sync_tree

AT_ONCE: Final = 2  # bundles that are unpacked at a time


class Intake:
    """Accepts submissions and unpacks their bundles.

    Args:
        blobs: Files of the bundles.
    """

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs
        self._threads: anyio.CapacityLimiter | None = None  # belongs to an event loop
        self._locks: dict[str, tuple[anyio.Lock, list[str]]] = {}  # by run, with the submitters
        self._sizes: dict[RunFolder, int] = {}  # [bytes] of bundles that are being unpacked

    @asynccontextmanager
    async def one(self, run: str, by: str) -> AsyncIterator[None]:
        """Accept a run while the block lasts; a repeated submission of it waits."""
        lock, submitters = self._locks.setdefault(run, (anyio.Lock(), []))
        submitters.append(by)
        try:
            async with lock:
                yield
        finally:
            submitters.remove(by)
            if not submitters:
                del self._locks[run]

    def arriving_of(self, by: str) -> int:
        """Return the number of runs of a submitter that are being accepted."""
        return sum(by in submitters for _, submitters in self._locks.values())

    async def lay_out(self, manifest: wire.Manifest, folder: RunFolder, limits: Limits) -> None:
        """Unpack a bundle before its run is stored; the next start removes incomplete folders.

        Raises:
            RequestRefused: The bundle is invalid, blobs are missing, or the disk is full.
        """
        if self._threads is None:
            self._threads = anyio.CapacityLimiter(AT_ONCE)
        self._sizes[folder] = sum(file.size for file in manifest.files)
        try:
            await anyio.to_thread.run_sync(self._lay_out, manifest, folder, limits, limiter=self._threads)
        finally:
            del self._sizes[folder]

    def _lay_out(self, manifest: wire.Manifest, folder: RunFolder, limits: Limits) -> None:
        hashes = {file.hash for file in manifest.files}
        with self._blobs.in_use(hashes):
            self._check_there(hashes)
            try:
                self._blobs.use(hashes)
                check_manifest(manifest)
                make_room(self._blobs, self._blobs.folder, sum(tuple(self._sizes.values())), limits, hashes)
                unpack(manifest, self._blobs.path, folder.files)
                sync_tree(folder.path)
                sync_folder(folder.path.parent)
            except (InvalidBundle, OSError) as error:
                shutil.rmtree(folder.path, ignore_errors=True)
                self._check_there(hashes)  # old blobs may be removed at any time
                raise rejected_bundle(str(error)) from error

    def _check_there(self, hashes: Collection[str]) -> None:
        if missing := self._blobs.missing(hashes):
            raise RequestRefused(wire.INCOMPLETE_BUNDLE, f"{len(missing)} blobs of the bundle are missing")


def rejected_bundle(reason: str) -> RequestRefused:
    """Return the error for a bundle that cannot be stored."""
    return RequestRefused(Result.OPERATION_FAILED, f"cannot store the bundle: {reason}")
