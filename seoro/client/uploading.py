"""Upload of the files of a bundle that are missing at an executor."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Final, TypeVar

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.results import Result
from seoro.bundle.pack import Bundle
from seoro.errors import BackendRefused, UsageError

TIMES: Final = 3  # attempts to send a file

T = TypeVar("T")


async def with_files(executor: Executor, bundle: Bundle, ask: Callable[[tuple[str, ...]], Awaitable[T]]) -> T:
    """Send missing files, and then a request that needs them.

    Args:
        executor: The executor.
        bundle: The bundle.
        ask: Sends the request, with the hashes of sent files; called again if files were removed meanwhile.

    Raises:
        UsageError, BackendError: As `upload` and `ask`.
    """
    sent = await upload(executor, bundle)
    try:
        return await ask(sent)
    except BackendRefused as refused:
        if refused.code != wire.INCOMPLETE_BUNDLE:
            raise
    return await ask((*sent, *await upload(executor, bundle)))


async def upload(executor: Executor, bundle: Bundle) -> tuple[str, ...]:
    """Send missing files; returns their hashes.

    Raises:
        UsageError: A file has changed since the bundle was made.
        BackendError: The executor rejects a file, or does not answer.
    """
    missing = await executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))
    sizes = {file.hash: file.size for file in bundle.manifest.files}
    for digest in missing.hashes:
        await _send(executor, digest, bundle.blobs[digest], sizes[digest])
    return missing.hashes


async def _send(executor: Executor, digest: str, path: Path, size: int) -> None:
    """Send a file; again from its start if the executor has lost its first parts, or has other ones."""
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
                raise UsageError(f"{path} changed during the upload")
            await executor.ask(wire.PUT_BLOB, wire.PutBlob(hash=digest, size=size, offset=offset, data=data))
            offset += max(len(data), 1)
