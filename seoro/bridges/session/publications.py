"""Publishing and subscribing.

Late subscribers receive the kept samples of publishers: Zenoh's advanced publishers hold their last samples under
a second key, which advanced subscribers query. Such a subscriber also queries missed samples, if the publisher
announces the number of sent samples.

Nothing here waits for a slow receiver. A publisher drops samples when its link is full: Zenoh's alternative blocks
the caller for seconds and then disconnects.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from typing import Any, NamedTuple

import zenoh
import zenoh.ext
from zenoh.handlers import Callback

from seoro.bridges.session.asynchronous import AsyncSession
from seoro.bridges.session.core import Session
from seoro.bridges.session.declaring import declared, undeclare
from seoro.bridges.session.errors import SessionError
from seoro.bridges.session.mailbox import LATEST, Mailbox
from seoro.bridges.session.requests import MAX_ATTACHMENT, to_bytes

HEARTBEAT = 0.5  # [s] delay of the announced number of samples, for subscribers that recover missed ones


class Sample(NamedTuple):
    """Published sample.

    Attributes:
        key: Key of the publication.
        attachment: Attachment; empty without one.
        arrived: Time of arrival by the clock of this machine [ns since the epoch].
    """

    key: str
    payload: bytes
    attachment: bytes
    arrived: int


class Publisher:
    """Publisher on one key. Created by `publishing`."""

    def __init__(self, publisher: Any, key: str) -> None:
        self._publisher = publisher
        self._key = key

    def put(self, payload: bytes, attachment: bytes | None = None) -> None:
        """Publish; never waits for receivers.

        Raises:
            SessionError: The publisher or its session is closed.
        """
        try:
            self._publisher.put(payload, attachment=attachment)
        except zenoh.ZError as error:
            raise SessionError(f"cannot publish on {self._key}: {error}") from error

    @property
    def has_subscribers(self) -> bool:
        """Whether the key has a subscriber."""
        return bool(self._publisher.matching_status.matching)

    def close(self) -> None:
        """End the publication."""
        undeclare(self._publisher.undeclare)

    async def wait_for_subscriber(self) -> None:
        """Wait until the key has a subscriber; a publisher that keeps samples returns at once."""
        if isinstance(self._publisher, zenoh.ext.AdvancedPublisher):
            return
        matches: Mailbox[bool] = Mailbox(LATEST)

        def take(status: zenoh.MatchingStatus) -> None:
            matches.put(status.matching, 1)

        callback = Callback(take, indirect=False)
        async with declared(partial(self._publisher.declare_matching_listener, callback), _end):
            while not (self._publisher.matching_status.matching or await matches.get()):
                pass


def declare_publisher(session: Session, key: str) -> Publisher:
    """Declare a publisher without an event loop, until it is closed; it keeps no samples."""
    return Publisher(_declare_publisher(session, key, reliable=True, keep=0, recover=False), key)


def declare_subscriber(session: Session, key: str, take: Callable[[bytes, bytes], None], largest: int) -> None:
    """Subscribe without an event loop, until the session closes.

    Args:
        session: Session to subscribe with.
        key: A key expression, wildcards included.
        take: Called with payload and attachment on a thread of Zenoh; must not wait.
        largest: Size limit of payloads [bytes]; larger ones are passed as empty, without a copy.
    """

    def receive(sample: zenoh.Sample) -> None:
        take(to_bytes(sample.payload, largest), to_bytes(sample.attachment, MAX_ATTACHMENT))

    session.keep(_declare_subscriber(session, key, receive, history=0, recover=False))


@asynccontextmanager
async def publishing(
    session: AsyncSession,
    key: str,
    *,
    reliable: bool = True,
    keep: int = 0,
    recover: bool = False,
    is_urgent: bool = False,
) -> AsyncIterator[Publisher]:
    """Declare a publisher on a key while the block lasts.

    Args:
        session: Session to publish with.
        key: A key, or a key expression for all matching subscribers.
        reliable: Whether links that can lose data send it again.
        keep: Number of samples kept for late subscribers.
        recover: Whether subscribers can detect missed samples, and query kept ones.
        is_urgent: Whether samples overtake all other messages.
    """
    declare = partial(_declare_publisher, reliable=reliable, keep=keep, recover=recover, is_urgent=is_urgent)
    async with declared(partial(declare, session.blocking, key), _end) as publisher:
        yield Publisher(publisher, key)


@asynccontextmanager
async def subscribing(
    session: AsyncSession, key: str, take: Callable[[Sample], None], *, history: int = 0, recover: bool = False
) -> AsyncIterator[None]:
    """Subscribe to a key expression while the block lasts.

    Args:
        session: Session to subscribe with.
        key: A key expression, wildcards included.
        take: Called with samples on a thread of Zenoh; must not wait.
        history: Number of earlier samples to query from each publisher.
        recover: Whether to query missed samples.
    """

    def receive(sample: zenoh.Sample) -> None:
        attachment = to_bytes(sample.attachment)
        take(Sample(str(sample.key_expr), sample.payload.to_bytes(), attachment, time.time_ns()))

    declare = partial(_declare_subscriber, session.blocking, key, receive, history=history, recover=recover)
    async with declared(declare, _end):
        yield


def _declare_publisher(
    session: Session, key: str, *, reliable: bool, keep: int, recover: bool, is_urgent: bool = False
) -> Any:
    options: dict[str, Any] = {
        "congestion_control": zenoh.CongestionControl.DROP,
        "reliability": zenoh.Reliability.RELIABLE if reliable else zenoh.Reliability.BEST_EFFORT,
        "priority": zenoh.Priority.REAL_TIME if is_urgent else zenoh.Priority.DATA,
        "express": is_urgent,
    }
    try:
        if not keep:
            return session.handle.declare_publisher(key, **options)
        if recover:
            options["sample_miss_detection"] = zenoh.ext.MissDetectionConfig(
                heartbeat=None, sporadic_heartbeat=HEARTBEAT
            )
        cache = zenoh.ext.CacheConfig(keep)
        return zenoh.ext.declare_advanced_publisher(
            session.handle, key, cache=cache, publisher_detection=True, **options
        )
    except zenoh.ZError as error:
        raise SessionError(f"cannot publish on {key}: {error}") from error


def _declare_subscriber(
    session: Session, key: str, take: Callable[[zenoh.Sample], None], *, history: int, recover: bool
) -> Any:
    callback = Callback(take, indirect=False)
    try:
        if not history:
            return session.handle.declare_subscriber(key, callback)
        past = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=history)
        missed = zenoh.ext.RecoveryConfig(periodic_queries=None, heartbeat=True) if recover else None
        return zenoh.ext.declare_advanced_subscriber(
            session.handle, key, callback, history=past, recovery=missed, subscriber_detection=True
        )
    except zenoh.ZError as error:
        raise SessionError(f"cannot subscribe to {key}: {error}") from error


def _end(declaration: Any) -> None:
    undeclare(declaration.undeclare)
