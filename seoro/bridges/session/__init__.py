"""Zenoh for the rest of seoro: sessions, requests, publications and liveliness, out of Zenoh's threads.

`core.py` opens sessions at endpoints (`endpoints.py`), asks and answers, and follows liveliness, and
`asynchronous.py` does so for asyncio; `errors.py` says what can go wrong. `parts.py` asks for answers in parts;
`publications.py` publishes and subscribes; `mailbox.py` is where Zenoh's threads leave what has arrived for the
event loop; `declaring.py` sees to it that what was declared is undeclared. `outages.py` records when a connection
was lost. `security.py` is what keys mean to Zenoh. No other package imports zenoh.
"""

from seoro.bridges.session.asynchronous import Answer, AsyncSession, Check, Reply, form_of, open_session
from seoro.bridges.session.core import Session
from seoro.bridges.session.endpoints import is_endpoint, is_local, is_secured
from seoro.bridges.session.errors import InvalidEndpoint, NoAnswer, NoServer, NotAuthentic, Refused, SessionError
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.outages import Outages
from seoro.bridges.session.parts import asking_for_parts
from seoro.bridges.session.publications import (
    Publisher,
    Sample,
    declare_publisher,
    declare_subscriber,
    publishing,
    subscribing,
)
from seoro.bridges.session.requests import Attestor, Form, Intake, Request
from seoro.bridges.session.security import Security

__all__ = [
    "Answer",
    "AsyncSession",
    "Attestor",
    "Bound",
    "Check",
    "Form",
    "Intake",
    "InvalidEndpoint",
    "Mailbox",
    "NoAnswer",
    "NoServer",
    "NotAuthentic",
    "Outages",
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
    "form_of",
    "is_endpoint",
    "is_local",
    "is_secured",
    "open_session",
    "publishing",
    "subscribing",
]
