"""Hearing of emergency stops that are published, also by those who do not know that this node is there."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from seoro.bridges import wire
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Sample, subscribing

WAITING = Bound(64, lose="newest")  # of which one would do


@asynccontextmanager
async def emergencies(
    session: AsyncSession, namespace: str, obeys: Callable[[str, bytes, bytes], bool]
) -> AsyncIterator[AsyncIterator[wire.EmergencyStop]]:
    """Every emergency stop that is published while the block lasts, whatever it says.

    Args:
        session: The session.
        namespace: The namespace.
        obeys: Whether one is by somebody who may, by its key, its payload and its seal.
    """
    heard: Mailbox[Sample] = Mailbox(WAITING)

    def take(sample: Sample) -> None:
        heard.put(sample, 1)

    async with subscribing(session, wire.emergency_key(namespace), take):
        try:
            yield _read(heard, obeys)
        finally:
            heard.close()


async def _read(
    heard: Mailbox[Sample], obeys: Callable[[str, bytes, bytes], bool]
) -> AsyncIterator[wire.EmergencyStop]:
    async for sample in heard:
        if not obeys(sample.key, sample.payload, sample.attachment):
            continue
        try:
            yield wire.decode(wire.EmergencyStop, sample.payload)
        except wire.WireError:
            yield wire.EmergencyStop(by="somebody whose message cannot be read")
