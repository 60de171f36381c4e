"""Subscriptions to events of runs on executors."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

from seoro.concurrency.background import background
from seoro.embed.subscriptions import EventSubscription, OnFull
from seoro.errors import BackendError
from seoro.runtime.events.occurrence import occurrence_in, without_attempts


@asynccontextmanager
async def open_subscription(
    records: AsyncIterator[Mapping[str, Any]], event: str, capacity: int, on_full: OnFull
) -> AsyncIterator[EventSubscription]:
    """Subscribe to an event of a run while a block lasts.

    Args:
        records: Records of its trace, from the first on.
        event: Name of the event, with or without the name of the entry scenario.
        capacity: Capacity of the buffer.
        on_full: Behavior when the buffer is full.
    """
    subscription = EventSubscription(event, capacity, on_full)
    async with background() as tasks:
        tasks.start_soon(_feed, records, event, subscription)
        try:
            yield subscription
        finally:
            subscription.end()


async def _feed(records: AsyncIterator[Mapping[str, Any]], event: str, subscription: EventSubscription) -> None:
    """Pass the occurrences of an event to a subscription, until the end of the run."""
    names = {without_attempts(event)}
    try:
        async for record in records:
            if record["kind"] == "run.start":
                names.add(f"{record['scenario']}.{without_attempts(event)}")
            elif record["kind"] == "event" and without_attempts(record["name"]) in names:
                subscription.push(occurrence_in(record))
    except BackendError as error:
        subscription.end(error)
    else:
        subscription.end()
