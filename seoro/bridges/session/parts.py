"""Asking for what is answered in parts, as it comes about; the last part ends the answer."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import TypeAlias

import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.asynchronous import AsyncSession, Reply
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.requests import PART

WAITING = Bound(1 << 14)  # parts that wait to be looked at; the last, which says that it is, is never lost

_Answer: TypeAlias = tuple[bool, Reply]


@asynccontextmanager
async def asking_for_parts(
    session: AsyncSession, key: str, payload: bytes, timeout: float, attachment: bytes | None = None
) -> AsyncIterator[AsyncIterator[tuple[bool, bytes]]]:
    """Ask one server, and take what it answers as it comes. When the block ends, nobody waits for more.

    A part can be lost, if the link is full or whoever takes them is too slow: parts have to say where they belong.

    Args:
        session: That asks.
        key: Key that the server serves.
        payload: The request.
        timeout: [s] of the machine's clock, for the whole answer.
        attachment: What travels beside the payload.

    Yields whether it is a part, and what it says. After the answer there is nothing more; if there is none,
    `NoServer`, `NoAnswer` or `Refused` is raised.
    """
    answers: Mailbox[_Answer] = Mailbox(WAITING)

    def take(reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            data, beside = reply.ok.payload.to_bytes(), reply.ok.attachment
            is_part = beside is not None and beside.to_bytes() == PART
            answers.put((is_part, Reply(((True, data),))), len(data))
        elif reply.err is not None:
            data = reply.err.payload.to_bytes()
            answers.put((False, Reply(((False, data),))), len(data))

    over = partial(answers.put, (False, Reply(())), 0)
    cancel = session.blocking.get(
        key,
        payload,
        timeout,
        Callback(take, drop=over, indirect=False),
        attachment,
        zenoh.ConsolidationMode.NONE,  # each part as it comes
    )
    try:
        yield _values(answers, key)
    finally:
        cancel()


async def _values(answers: Mailbox[_Answer], key: str) -> AsyncIterator[tuple[bool, bytes]]:
    is_part = True
    while is_part:
        is_part, reply = await answers.take()
        yield is_part, reply.value(key)
