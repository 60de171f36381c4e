"""The end of the backends of a run."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from seoro.errors import BackendError
from seoro.runtime.contracts.backends import Backend


async def end_backends(backends: Sequence[Backend], grace: float) -> None:
    """Stop the robots of all backends, the last backend first. Lost backends are skipped.

    Args:
        backends: Backends of the run.
        grace: Time limit for each backend [s].
    """
    import anyio  # noqa: PLC0415 - runs without backends need none of it

    for backend in reversed(backends):
        with anyio.move_on_after(grace), suppress(BackendError):
            await backend.end_run()
