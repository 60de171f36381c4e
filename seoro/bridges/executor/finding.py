"""Which executors there are."""

from __future__ import annotations

from typing import Final

import anyio

from seoro.bridges.executor.asking import NAMESPACE, Executor
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import executor_tokens, token_node
from seoro.errors import InvalidUse

ENDPOINT: Final = "tcp/127.0.0.1:7470"  # at which executors listen, unless it is said otherwise
TIMEOUT: Final = 2.0  # [s]


async def find_executors(session: AsyncSession) -> list[Executor]:
    """All executors that a session reaches, by their names; waits a little for the first."""
    tokens: frozenset[str] = frozenset()
    with anyio.move_on_after(TIMEOUT):
        while not tokens:
            tokens = await session.list_tokens(executor_tokens(NAMESPACE), TIMEOUT)
    return [Executor(session, name) for name in sorted({token_node(token)[0] for token in tokens})]


async def find_executor(session: AsyncSession, name: str) -> Executor:
    """The executor of a name, which is waited for a little: it may be about to start.

    Raises:
        InvalidUse: There is none.
    """
    with anyio.move_on_after(TIMEOUT):
        async with session.tokens(executor_tokens(NAMESPACE)) as tokens:
            async for token, alive in tokens:
                if alive and token_node(token)[0] == name:
                    return Executor(session, name)
    known = ", ".join(executor.name for executor in await find_executors(session))
    raise InvalidUse(
        f"there is no executor '{name}' here",
        help=f"there are {known}" if known else f"start it with `seoro serve --name {name}`",
    )
