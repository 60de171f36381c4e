"""There is one executor of a name: who asks for it must not reach now one and now another."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

import anyio

from seoro.bridges.executor.messages import MINOR
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import NAMESPACE, executor_token, executor_tokens_of
from seoro.errors import InvalidUse

TIMEOUT: Final = 2.0  # [s] for a list of tokens
PATIENCE: Final = 1.0  # [s] in which an executor that was killed is noticed to be gone


async def await_name(session: AsyncSession, name: str) -> None:
    """Wait a little until nobody has a name, to be called before anything is served under it.

    Raises:
        InvalidUse: Somebody has it.
    """
    alive = set(await _holders(session, name))
    if not alive:
        return
    with anyio.move_on_after(PATIENCE):
        async with session.tokens(executor_tokens_of(NAMESPACE, name)) as changes:
            async for token, is_alive in changes:
                (alive.add if is_alive else alive.discard)(token)
                if not alive:
                    break
    if await _holders(session, name):
        raise _taken(name)


@asynccontextmanager
async def announced(session: AsyncSession, name: str) -> AsyncIterator[None]:
    """Be known by a name for as long as the block lasts.

    Raises:
        InvalidUse: Another has come to have it at the same moment; of two, one goes on.
    """
    token = executor_token(NAMESPACE, name, f"{MINOR}-{secrets.token_hex(8)}")
    async with session.token(token):
        if min({token, *await _holders(session, name)}) != token:
            raise _taken(name)
        yield


async def _holders(session: AsyncSession, name: str) -> frozenset[str]:
    return await session.list_tokens(executor_tokens_of(NAMESPACE, name), TIMEOUT)


def _taken(name: str) -> InvalidUse:
    return InvalidUse(f"there is an executor '{name}' already", help="`--name` gives this one another name")
