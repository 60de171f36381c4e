"""Which executors there are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import anyio

from seoro.bridges.executor.asking import Executor
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import NAMESPACE, executor_tokens, token_node
from seoro.errors import InvalidUse

TIMEOUT: Final = 2.0  # [s]


async def find_executors(session: AsyncSession) -> list[Executor]:
    """All executors that a session reaches, by their names; waits a little for the first."""
    found: set[str] = set()
    with anyio.move_on_after(TIMEOUT):
        async with session.tokens(executor_tokens(NAMESPACE)) as tokens:
            found.add((await anext(tokens))[0])
            found |= await session.list_tokens(executor_tokens(NAMESPACE), TIMEOUT)
    return [Executor(session, name) for name in _names(found)]


def _names(tokens: Iterable[str]) -> list[str]:
    return sorted({token_node(token)[0] for token in tokens})


async def find_executor(session: AsyncSession, name: str) -> Executor:
    """The executor of a name, which is waited for a little: it may be about to start.

    Raises:
        InvalidUse: There is none.
    """
    others: set[str] = set()
    with anyio.move_on_after(TIMEOUT):
        async with session.tokens(executor_tokens(NAMESPACE)) as tokens:
            async for token, alive in tokens:
                if alive and token_node(token)[0] == name:
                    return Executor(session, name)
                (others.add if alive else others.discard)(token)
    known = ", ".join(_names(others))
    raise InvalidUse(
        f"there is no executor '{name}' here",
        help=f"there are {known}" if known else f"start it with `seoro serve --name {name}`",
    )
