"""Output folder of a debugged run: its trace, pictures for viewers, and files of actions."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from seoro.embed.output_folder import OutputFolder
from seoro.errors import UsageError
from seoro.runtime.execution.outputs import TRACE
from seoro.runtime.trace.jsonl import JsonLines


@asynccontextmanager
async def writing_trace(folder: Path) -> AsyncIterator[JsonLines]:
    """Write the trace of a run to a folder while the block lasts; yields its observer.

    Results of an earlier run there are removed.

    Args:
        folder: The folder; created if missing.

    Raises:
        UsageError: The folder or the trace cannot be written.
    """
    output = OutputFolder(folder)
    async with AsyncExitStack() as opened:
        try:
            output.claim()
            opened.callback(output.close)
            file = opened.enter_context((folder / TRACE).open("wb", buffering=0))
        except OSError as error:
            raise UsageError(
                f"cannot write {error.filename or folder}: {error.strerror}", help="choose another `output`"
            ) from error
        trace = JsonLines(file, str(folder / TRACE))
        try:
            yield trace
        finally:
            try:
                await trace.finish()
            except OSError as error:
                raise UsageError(f"the trace is incomplete: {error}") from error
