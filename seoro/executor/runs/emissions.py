"""Events that clients emit in a run."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import encode
from seoro.bridges.wire.refusal import RequestRefused

KEPT: Final = 1000  # answered emissions that are kept, since clients repeat requests
MOST_PENDING: Final = 32 << 10  # [bytes] of unanswered emissions; the pipe of the process has room for more

OVER: Final = "the run is over: cannot emit events"


class Emissions:
    """Emissions in one run by their ids; a repeated request is one emission."""

    def __init__(self) -> None:
        self._found: dict[str, asyncio.Future[wire.Emitted]] = {}  # oldest first
        self._pending: dict[str, int] = {}  # sizes of unanswered emissions [bytes]

    async def emit(self, request: wire.EmitEvent, send: Callable[[bytes], object]) -> wire.Emitted:
        """Emit an event, and wait until it has occurred, at most for the time in the request.

        Args:
            request: The emission.
            send: Sends it to the process of the run.

        Raises:
            RequestRefused: The run rejects it, or too many emissions are pending.
        """
        found = self._found.get(request.emission)
        if found is None:
            found = self._begin(request, send)
        try:
            async with asyncio.timeout(request.wait):
                emitted = await asyncio.shield(found)
        except TimeoutError:
            return wire.Emitted(emission=request.emission)
        if emitted.refused:
            raise RequestRefused(wire.NOT_EMITTED, emitted.refused)
        return emitted

    def _begin(self, request: wire.EmitEvent, send: Callable[[bytes], object]) -> asyncio.Future[wire.Emitted]:
        data = encode(request)
        if sum(self._pending.values()) + len(data) > MOST_PENDING:
            raise RequestRefused(wire.UNAVAILABLE, "too many pending events in this run: try again later")
        answered = [each for each in self._found if each not in self._pending]
        for emission in answered[: max(0, len(self._found) + 1 - KEPT)]:
            del self._found[emission]
        found = self._found[request.emission] = asyncio.get_running_loop().create_future()
        self._pending[request.emission] = len(data)
        send(data)
        return found

    def conclude(self, emitted: wire.Emitted) -> None:
        """Store the outcome of an emission."""
        found = self._found.get(emitted.emission)
        self._pending.pop(emitted.emission, None)
        if found is not None and not found.done():
            found.set_result(emitted)

    def end(self) -> None:
        """Reject all pending emissions: the process of the run has ended."""
        for emission in list(self._pending):
            self.conclude(wire.Emitted(emission=emission, refused=OVER))
