"""Names under which something is reached: of two who have one, now one would be reached and now the other."""

from __future__ import annotations

from typing import Final

import anyio

from seoro.bridges.session import AsyncSession

TIMEOUT: Final = 2.0  # [s] for a list of tokens
PATIENCE: Final = 1.0  # [s] in which somebody who was killed is noticed to be gone


async def holders(session: AsyncSession, tokens: str) -> frozenset[str]:
    """The tokens of those who have a name, by the key expression of these."""
    return await session.list_tokens(tokens, TIMEOUT)


async def becomes_free(session: AsyncSession, tokens: str) -> bool:
    """Wait a little until nobody has a name, and return whether that is so.

    Args:
        session: Where it has to be free.
        tokens: Key expression of the tokens of those who have it.
    """
    alive = set(await holders(session, tokens))
    if not alive:
        return True
    with anyio.move_on_after(PATIENCE):
        async with session.tokens(tokens) as changes:
            async for token, is_alive in changes:
                (alive.add if is_alive else alive.discard)(token)
                if not alive:
                    break
    return not await holders(session, tokens)
