"""Asking for what is answered in parts, as it comes about; the last part ends the answer."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial

import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.asynchronous import AsyncSession, Check, Reply, arrived, form_of
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.requests import Form

WAITING = Bound(1 << 14)  # parts that wait to be looked at; the last, which says that it is, is never lost


@asynccontextmanager
async def asking_for_parts(
    session: AsyncSession,
    key: str,
    payload: bytes,
    timeout: float,
    attachment: bytes | None = None,
    check: Check = form_of,
) -> AsyncIterator[AsyncIterator[tuple[bool, bytes]]]:
    """Ask one server, and take what it answers as it comes. When the block ends, nobody waits for more.

    A part can be lost, if the link is full or whoever takes them is too slow: parts have to say where they belong.

    Args:
        session: That asks.
        key: Key that the server serves.
        payload: The request.
        timeout: [s] of the machine's clock, for the whole answer.
        attachment: What travels beside the payload.
        check: Checks that parts and the answer are authentic.

    Yields whether it is a part, and what it says. After the answer there is nothing more; if there is none,
    `NoServer`, `NoAnswer`, `Refused` or `NotAuthentic` is raised.
    """
    answers: Mailbox[Reply] = Mailbox(WAITING)

    def take(reply: zenoh.Reply) -> None:
        if (answer := arrived(reply)) is not None:
            answers.put(Reply((answer,)), len(answer.payload))

    over = partial(answers.put, Reply(()), 0)
    cancel = session.blocking.get(
        key,
        payload,
        timeout,
        Callback(take, drop=over, indirect=False),
        attachment,
        zenoh.ConsolidationMode.NONE,  # each part as it comes
    )
    try:
        yield _values(answers, key, check)
    finally:
        cancel()


async def _values(answers: Mailbox[Reply], key: str, check: Check) -> AsyncIterator[tuple[bool, bytes]]:
    is_part = True
    while is_part:
        form, payload = (await answers.take()).formed(key, check)
        is_part = form is Form.PART
        yield is_part, payload
