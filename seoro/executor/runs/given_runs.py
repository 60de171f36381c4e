"""Planned runs on their way to the worker of a campaign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import encode
from seoro.bridges.wire.refusal import RequestRefused

MOST_PENDING: Final = 32 << 10  # [bytes] that the process has not read; its pipe has room for more


class GivenRuns:
    """Planned runs for one process, in numbered parts; a repeated part is passed on once."""

    def __init__(self) -> None:
        self._part = 0  # last one
        self._pending: dict[int, int] = {}  # sizes of parts that the process has not read [bytes]

    def give(self, request: wire.PlannedRuns, send: Callable[[bytes], object]) -> None:
        """Pass runs on.

        Args:
            request: The runs.
            send: Sends them to the process.

        Raises:
            RequestRefused: The process has not read earlier ones.
        """
        if request.part <= self._part:
            return
        data = encode(request)
        if self._pending and sum(self._pending.values()) + len(data) > MOST_PENDING:
            raise RequestRefused(wire.UNAVAILABLE, "the worker has not read earlier runs: try again later")
        self._part = request.part
        self._pending[request.part] = len(data)
        send(data)

    def note_read(self, part: int) -> None:
        """Record that the process has read a part."""
        self._pending.pop(part, None)
