"""Zenoh sessions, requests, publications and liveliness, moved from Zenoh's threads to asyncio.

`Session` works in any thread, `AsyncSession` adapts it to asyncio, and `query_parts` receives streamed answers.
`Publisher` and `Sample` are for publications. `Mailbox` passes messages from Zenoh's threads to the event loop,
`Outages` records lost connections, and `Security` holds the keys for TLS. No other package imports zenoh.
"""

from seoro.bridges.session.asynchronous import (
    Answer,
    AsyncSession,
    Check,
    form_of,
    open_session,
    open_session_at_once,
    query_parts,
)
from seoro.bridges.session.core import Session
from seoro.bridges.session.endpoints import is_endpoint, is_local, is_secured
from seoro.bridges.session.errors import InvalidEndpoint, NoAnswer, NoServer, NotAuthentic, Refused, SessionError
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.outages import Outages
from seoro.bridges.session.publications import (
    Publisher,
    Sample,
    declare_publisher,
    declare_subscriber,
    publishing,
    subscribing,
)
from seoro.bridges.session.requests import AdmissionPolicy, Form, Request
from seoro.bridges.session.security import Security

__all__ = [
    "AdmissionPolicy",
    "Answer",
    "AsyncSession",
    "Bound",
    "Check",
    "Form",
    "InvalidEndpoint",
    "Mailbox",
    "NoAnswer",
    "NoServer",
    "NotAuthentic",
    "Outages",
    "Publisher",
    "Refused",
    "Request",
    "Sample",
    "Security",
    "Session",
    "SessionError",
    "declare_publisher",
    "declare_subscriber",
    "form_of",
    "is_endpoint",
    "is_local",
    "is_secured",
    "open_session",
    "open_session_at_once",
    "publishing",
    "query_parts",
    "subscribing",
]
