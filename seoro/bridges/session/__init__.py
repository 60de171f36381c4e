"""Zenoh for the rest of seoro: sessions, requests, publications and liveliness, out of Zenoh's threads.

`core.py` opens sessions at endpoints (`endpoints.py`), asks and answers, and follows liveliness, and
`asynchronous.py` does so for asyncio; `errors.py` says what can go wrong. `parts.py` asks for answers in parts;
`publications.py` publishes and subscribes; `mailbox.py` is where Zenoh's threads leave what has arrived for the
event loop; `declaring.py` sees to it that what was declared is undeclared. `security.py` is what keys mean to
Zenoh. No other package imports zenoh.
"""

from seoro.bridges.session.asynchronous import AsyncSession, Reply, open_session
from seoro.bridges.session.core import Session
from seoro.bridges.session.endpoints import is_endpoint, is_local, is_secured
from seoro.bridges.session.errors import InvalidEndpoint, NoAnswer, NoServer, Refused, SessionError
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.parts import asking_for_parts
from seoro.bridges.session.publications import (
    Publisher,
    Sample,
    declare_publisher,
    declare_subscriber,
    publishing,
    subscribing,
)
from seoro.bridges.session.requests import Intake, Request
from seoro.bridges.session.security import Security

__all__ = [
    "AsyncSession",
    "Bound",
    "Intake",
    "InvalidEndpoint",
    "Mailbox",
    "NoAnswer",
    "NoServer",
    "Publisher",
    "Refused",
    "Reply",
    "Request",
    "Sample",
    "Security",
    "Session",
    "SessionError",
    "asking_for_parts",
    "declare_publisher",
    "declare_subscriber",
    "is_endpoint",
    "is_local",
    "is_secured",
    "open_session",
    "publishing",
    "subscribing",
]
