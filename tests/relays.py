"""A hostile router for tests, which changes requests and replies as a test demands."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio
import zenoh
from anyio.abc import TaskGroup, TaskStatus
from zenoh.handlers import Callback

from seoro.bridges.session import Answer, AsyncSession, Bound, Mailbox, Request, Security, open_session
from seoro.concurrency.background import background

TIMEOUT = 20.0  # [s]
KEYS = "seoro/1/default/*/*/cmd/*"

Change = Callable[[str, list[Answer]], list[Answer]]
"""Condition the answers to a request for a verb."""


@dataclass(frozen=True)
class Sent:
    """A request on its way.

    Attributes:
        key: Its key expression.
        payload: The request.
        attachment: Its attachment.
    """

    key: str
    payload: bytes
    attachment: bytes

    @property
    def verb(self) -> str:
        """Name of its verb."""
        return self.key.rpartition("/")[2]


Forge = Callable[[Sent], Sent]
"""Condition a request."""


def honest(sent: Sent) -> Sent:
    """Pass a request on as it is."""
    return sent


def unchanged(_verb: str, answers: list[Answer]) -> list[Answer]:
    """Pass answers on as they are."""
    return answers


@dataclass
class Relay:
    """A relay between clients and the endpoint of an executor or a node. Made by `relaying`."""

    change: Change = unchanged
    forge: Forge = honest

    def replace(self, old: bytes, new: bytes, *verbs: str) -> None:
        """Change the content of replies to some verbs, or to all."""

        def change(verb: str, answers: list[Answer]) -> list[Answer]:
            if verbs and verb not in verbs:
                return answers
            return [each._replace(payload=each.payload.replace(old, new)) for each in answers]

        self.change = change

    def refuse(self, payload: bytes) -> None:
        """Refuse everything, without a signature."""
        self.change = lambda _verb, _answers: [Answer(False, payload)]

    async def serve(self, requests: Mailbox[Request], back: AsyncSession, tasks: TaskGroup) -> None:
        """Pass requests on."""
        async for request in requests:
            tasks.start_soon(self._pass_on, request, back)

    async def _pass_on(self, request: Request, back: AsyncSession) -> None:
        answers = await forward(back, self.forge(Sent(request.key, request.payload, request.attachment)))
        with request._query:
            for answer in self.change(request.key.rpartition("/")[2], answers):
                if answer.is_ok:
                    request._query.reply(request.key, answer.payload, attachment=answer.attachment or None)
                else:
                    request._query.reply_err(answer.payload)


async def forward(back: AsyncSession, sent: Sent) -> list[Answer]:
    """Return all replies to a request."""
    answers: Mailbox[Answer | None] = Mailbox(Bound(1 << 14))

    def take(reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            attachment = reply.ok.attachment
            answer = Answer(
                True, reply.ok.payload.to_bytes(), b"" if attachment is None else attachment.to_bytes()
            )
            answers.put(answer, 1)
        elif reply.err is not None:
            answers.put(Answer(False, reply.err.payload.to_bytes()), 1)

    over = Answer(False, b"over")
    callback = Callback(take, drop=lambda: answers.put(over, 1) and None, indirect=False)
    consolidation = zenoh.ConsolidationMode.NONE
    back.blocking.get(sent.key, sent.payload, TIMEOUT, callback, sent.attachment or None, consolidation)
    found: list[Answer] = []
    while (answer := await answers.get()) is not None and answer is not over:
        found.append(answer)
    return found


@asynccontextmanager
async def relaying(
    endpoint: str,
    reached: str,
    keys: tuple[Security | None, Security | None] = (None, None),
) -> AsyncIterator[Relay]:
    """Relay between clients and an endpoint during the block.

    Args:
        endpoint: Endpoint for clients.
        reached: Endpoint of the executor or node.
        keys: Keys of the sessions at the first and the second endpoint.
    """
    relay = Relay()
    async with (
        open_session(listen=endpoint, security=keys[0]) as front,
        open_session(connect=reached, security=keys[1]) as back,
        front.answering(KEYS, Bound(100), b"busy") as requests,
        front.tokens("seoro/1/default/alive/holder/*") as changes,
        background() as tasks,
    ):
        for token in await back.list_tokens("seoro/1/default/alive/**", TIMEOUT):
            await tasks.start(_live, front, token)
        tasks.start_soon(_follow, changes, back, tasks)
        tasks.start_soon(relay.serve, requests, back, tasks)
        yield relay


async def _live(session: AsyncSession, token: str, *, task_status: TaskStatus[None]) -> None:
    async with session.token(token):
        task_status.started()
        await anyio.sleep_forever()


async def _follow(changes: Mailbox[tuple[str, bool]], back: AsyncSession, tasks: TaskGroup) -> None:
    """Show at the other end who holds robots."""
    async for token, is_alive in changes:
        if is_alive:
            await tasks.start(_live, back, token)
