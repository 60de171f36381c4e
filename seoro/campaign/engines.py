"""Several engines as one."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence

import anyio

from seoro.campaign.engine import Engine, NotBegun
from seoro.campaign.runs import Planned, Row
from seoro.errors import cause_of


class Engines:
    """Engine that hands each chunk to the first of its engines with a free slot.

    Args:
        engines: The engines, the preferred ones first.
        most: Maximum number of simultaneous chunks; None for all slots.
    """

    def __init__(self, engines: Sequence[Engine], most: int | None = None) -> None:
        self._engines = engines
        self._taken = [0] * len(engines)
        self._most = most

    @property
    def slots(self) -> int:
        """Number of chunks that the engines take at once."""
        slots = sum(engine.slots for engine in self._engines)
        return slots if self._most is None else min(slots, self._most)

    async def slots_changed(self) -> None:
        """Wait for a change of any engine; see `Engine`."""

        async def wait(engine: Engine) -> None:
            await engine.slots_changed()
            group.cancel_scope.cancel()

        try:
            async with anyio.create_task_group() as group:
                for engine in self._engines:
                    group.start_soon(wait, engine)
        except ExceptionGroup as errors:
            raise cause_of(errors) from None

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk; see `Engine`."""
        free = (at for at, engine in enumerate(self._engines) if self._taken[at] < engine.slots)
        at = next(free, None)
        if at is None:
            raise NotBegun("no slot is free")
        self._taken[at] += 1
        try:
            async for row in self._engines[at].run(runs):
                yield row
        finally:
            self._taken[at] -= 1

    def stop(self) -> None:
        """Stop the runs in progress; see `Engine`."""
        for engine in self._engines:
            engine.stop()
