"""Publishing and subscribing.

Late subscribers get what publishers have kept for them: Zenoh's advanced publishers hold their last samples under
a key beside their own, and advanced subscribers ask there. Such a subscriber asks for what it has missed, too,
where the publisher tells how many it has sent.

Nothing here waits for a slow receiver: a publisher whose link is full drops, since the other way of Zenoh blocks
the caller for seconds and then breaks off the connection.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from functools import partial
from typing import Any, NamedTuple

import zenoh
import zenoh.ext
from zenoh.handlers import Callback

from seoro.bridges.session.asynchronous import AsyncSession
from seoro.bridges.session.core import Session
from seoro.bridges.session.declaring import declared
from seoro.bridges.session.errors import SessionError
from seoro.bridges.session.mailbox import LATEST, Mailbox
from seoro.bridges.session.requests import MOST_BESIDE

HEARTBEAT = 0.5  # [s] after a sample at the latest, subscribers that recover are told how many there were


class Sample(NamedTuple):
    """What has been published.

    Attributes:
        key: Key that it was published on.
        attachment: What travels beside the payload; empty when nothing does.
        arrived: [ns] since the epoch, by the clock of this machine.
    """

    key: str
    payload: bytes
    attachment: bytes
    arrived: int


class Publisher:
    """Publishes on one key. Made by `publishing`."""

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
    def is_taken(self) -> bool:
        """Whether somebody subscribes."""
        return bool(self._publisher.matching_status.matching)

    def close(self) -> None:
        """Publish nothing any more; a session that is closed has seen to that."""
        with suppress(zenoh.ZError):
            self._publisher.undeclare()

    async def wait_for_subscriber(self) -> None:
        """Wait until what is put arrives somewhere; a publisher that keeps samples need not, and does not."""
        if isinstance(self._publisher, zenoh.ext.AdvancedPublisher):
            return
        matches: Mailbox[bool] = Mailbox(LATEST)

        def take(status: zenoh.MatchingStatus) -> None:
            matches.put(status.matching, 1)

        callback = Callback(take, indirect=False)
        async with declared(partial(self._publisher.declare_matching_listener, callback), _undeclare):
            while not (self._publisher.matching_status.matching or await matches.take()):
                pass


def declare_publisher(session: Session, key: str) -> Publisher:
    """Be a publisher on a key until it is closed, for those who have no event loop; nothing is kept."""
    return Publisher(_declare_publisher(session, key, reliable=True, keep=0, recover=False), key)


def declare_subscriber(session: Session, key: str, take: Callable[[bytes, bytes], None], largest: int) -> None:
    """Subscribe until the session closes, for those who have no event loop.

    Args:
        session: Session to subscribe with.
        key: A key expression, wildcards included.
        take: Gets payloads, and what travels beside them, on a thread of Zenoh's, and must not wait.
        largest: [bytes] of a payload; of a larger one there is nothing, and nothing is copied.
    """

    def receive(sample: zenoh.Sample) -> None:
        payload, attachment = sample.payload, sample.attachment
        is_beside = attachment is not None and len(attachment) <= MOST_BESIDE
        take(
            payload.to_bytes() if len(payload) <= largest else b"",
            attachment.to_bytes() if attachment is not None and is_beside else b"",
        )

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
    """Be a publisher on a key for as long as the block lasts.

    Args:
        session: Session to publish with.
        key: A key, or a key expression, whose subscribers all get it.
        reliable: Whether links that can lose data send it again.
        keep: How many samples are kept for subscribers that come later.
        recover: Whether subscribers can find out what they have missed, and get it as long as it is kept.
        is_urgent: Whether it overtakes everything else on its way.
    """
    declare = partial(
        _declare_publisher,
        session.blocking,
        key,
        reliable=reliable,
        keep=keep,
        recover=recover,
        is_urgent=is_urgent,
    )
    async with declared(declare, _undeclare) as publisher:
        yield Publisher(publisher, key)


@asynccontextmanager
async def subscribing(
    session: AsyncSession, key: str, take: Callable[[Sample], None], *, history: int = 0, recover: bool = False
) -> AsyncIterator[None]:
    """Be a subscriber of a key expression for as long as the block lasts.

    Args:
        session: Session to subscribe with.
        key: A key expression, wildcards included.
        take: Gets samples on a thread of Zenoh's, and must not wait.
        history: How many samples to get that each publisher has published before and kept.
        recover: Whether to ask for samples that got lost on their way.
    """

    def receive(sample: zenoh.Sample) -> None:
        attachment = sample.attachment
        beside = b"" if attachment is None else attachment.to_bytes()
        take(Sample(str(sample.key_expr), sample.payload.to_bytes(), beside, time.time_ns()))

    declare = partial(_declare_subscriber, session.blocking, key, receive, history=history, recover=recover)
    async with declared(declare, _undeclare):
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


def _undeclare(what: Any) -> None:
    """Take back what was declared; a session that is closed has done so already."""
    with suppress(zenoh.ZError):
        what.undeclare()
