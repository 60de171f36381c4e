"""Sends an executor the files of a bundle that it does not have."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Final, TypeVar

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.results import Result
from seoro.bundle.packing import Bundle
from seoro.errors import BackendRefused, InvalidUse

TIMES: Final = 3  # that a file is begun

T = TypeVar("T")


async def with_files(executor: Executor, bundle: Bundle, ask: Callable[[tuple[str, ...]], Awaitable[T]]) -> T:
    """Send what is missing, and ask for something that needs it.

    Args:
        executor: The executor.
        bundle: What it has to have.
        ask: Gets the hashes of what was sent; is called once more if some of it was removed meanwhile.

    Raises:
        InvalidUse, BackendError: As `upload`, and what `ask` raises.
    """
    sent = await upload(executor, bundle)
    try:
        return await ask(sent)
    except BackendRefused as refused:
        if refused.code != wire.LACKING:
            raise
    return await ask((*sent, *await upload(executor, bundle)))


async def upload(executor: Executor, bundle: Bundle) -> tuple[str, ...]:
    """Send what is missing; returns the hashes of that.

    Raises:
        InvalidUse: A file has changed since the bundle was made.
        BackendError: The executor refuses it, or is gone.
    """
    missing = await executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))
    sizes = {file.hash: file.size for file in bundle.manifest.files}
    for digest in missing.hashes:
        await _send(executor, digest, bundle.blobs[digest], sizes[digest])
    return missing.hashes


async def _send(executor: Executor, digest: str, path: Path, size: int) -> None:
    """Send a file; anew, if what the executor had of it is gone, or was not this."""
    for left in reversed(range(TIMES)):
        try:
            await _send_parts(executor, digest, path, size)
            return
        except BackendRefused as refused:
            if refused.code != Result.INCORRECT_STATE or not left:
                raise


async def _send_parts(executor: Executor, digest: str, path: Path, size: int) -> None:
    offset = 0
    async with await anyio.open_file(path, "rb") as file:
        while offset < size or offset == 0:
            data = await file.read(wire.CHUNK)
            if len(data) < min(wire.CHUNK, size - offset):
                raise InvalidUse(f"{path} has changed while it was sent")
            await executor.ask(wire.PUT_BLOB, wire.PutBlob(hash=digest, size=size, offset=offset, data=data))
            offset += max(len(data), 1)
