"""Zenoh for the rest of seoro: sessions, requests, publications and liveliness, out of Zenoh's threads.

`core.py` opens sessions at endpoints (`endpoints.py`), asks and answers, and follows liveliness;
`publications.py` publishes and subscribes; `mailbox.py` is where Zenoh's threads leave what has arrived for the
event loop; `declaring.py` sees to it that what was declared is undeclared. No other package imports zenoh.
"""

from seoro.bridges.session.core import (
    AsyncSession,
    InvalidEndpoint,
    NoAnswer,
    NoServer,
    Refused,
    Reply,
    Request,
    Session,
    SessionError,
    open_session,
)
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.publications import Publisher, Sample, declare_publisher, publishing, subscribing

__all__ = [
    "AsyncSession",
    "Bound",
    "InvalidEndpoint",
    "Mailbox",
    "NoAnswer",
    "NoServer",
    "Publisher",
    "Refused",
    "Reply",
    "Request",
    "Sample",
    "Session",
    "SessionError",
    "declare_publisher",
    "open_session",
    "publishing",
    "subscribing",
]
