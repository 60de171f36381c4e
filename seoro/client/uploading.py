"""Sends an executor the files of a bundle that it does not have."""

from __future__ import annotations

from pathlib import Path

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bundle.packing import Bundle
from seoro.errors import InvalidUse


async def upload(executor: Executor, bundle: Bundle) -> None:
    """Send what is missing.

    Raises:
        InvalidUse: A file has changed since the bundle was made.
        BackendError: The executor refuses it, or is gone.
    """
    missing = await executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))
    sizes = {file.hash: file.size for file in bundle.manifest.files}
    for digest in missing.hashes:
        await _send(executor, digest, bundle.blobs[digest], sizes[digest])


async def _send(executor: Executor, digest: str, path: Path, size: int) -> None:
    offset = 0
    async with await anyio.open_file(path, "rb") as file:
        while offset < size or offset == 0:
            data = await file.read(wire.CHUNK)
            if len(data) < min(wire.CHUNK, size - offset):
                raise InvalidUse(f"{path} has changed while it was sent")
            await executor.ask(wire.PUT_BLOB, wire.PutBlob(hash=digest, size=size, offset=offset, data=data))
            offset += max(len(data), 1)
