"""Names under which something is reached: of two who have one, now one would be reached and now the other."""

from __future__ import annotations

import secrets
import time
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.session import AsyncSession, SessionError
from seoro.bridges.wire.message import WireError, decode, encode
from seoro.bridges.wire.proving import Challenge, Proof

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

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


async def is_proven(session: AsyncSession, key: str, keys: Keys) -> bool:
    """Whether another session proves that it has keys of the name that is in some keys.

    Args:
        session: That reaches others.
        key: On which they are challenged.
        keys: With the name.
    """
    from seoro.keys.errors import InvalidKeys  # noqa: PLC0415 - only where there are keys
    from seoro.keys.sealing import Sealer  # noqa: PLC0415 - the same

    nonce, asked = secrets.token_bytes(16), time.time_ns()
    try:
        answers = await session.query_others(key, encode(Challenge(nonce=nonce)), TIMEOUT)
    except SessionError:  # nobody is reached
        return False
    checking = Sealer(keys, keys.identity.name, keys.identity.role)
    for answer in answers:
        try:
            proof = decode(Proof, answer)
            times = (asked, time.time_ns())
            said = (proof.certificate, proof.signature, nonce, proof.boot, proof.now)
            checking.accept(*said, times, proof.exchange)
        except (WireError, InvalidKeys):
            continue
        return True
    return False
