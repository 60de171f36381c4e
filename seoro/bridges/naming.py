"""Names of servers, of which each must belong to one server: requests would reach any of several."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.session import AsyncSession, SessionError
from seoro.bridges.wire.authentication import Challenge, Proof
from seoro.bridges.wire.message import WireError, decode, encode

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

LIST_TIMEOUT: Final = 2.0  # [s]
RETRY: Final = 0.05  # [s] between two lists of tokens
PATIENCE: Final = 1.0  # [s] until the end of a killed server is noticed


async def wait_until_free(session: AsyncSession, tokens: str) -> bool:
    """Wait briefly until a name is free, and return whether it is.

    Args:
        session: Session that reaches the servers.
        tokens: Key expression of the tokens of servers with the name.
    """
    alive = set(await session.list_tokens(tokens, LIST_TIMEOUT))
    if not alive:
        return True
    with anyio.move_on_after(PATIENCE):
        async with session.tokens(tokens) as changes:
            async for token, is_alive in changes:
                (alive.add if is_alive else alive.discard)(token)
                if not alive:
                    break
    return not await session.list_tokens(tokens, LIST_TIMEOUT)


async def wait_for_tokens(
    session: AsyncSession, tokens: str, timeout: float, is_enough: Callable[[frozenset[str]], bool] = bool
) -> frozenset[str]:
    """List the live tokens of a key expression, again and again until they are enough or time is up.

    Args:
        session: Session that lists them.
        tokens: Key expression.
        timeout: Time limit [s].
        is_enough: Called with the live tokens.
    """
    found: frozenset[str] = frozenset()
    with anyio.move_on_after(timeout):
        while not is_enough(found := await session.list_tokens(tokens, timeout)):  # noqa: ASYNC110 - no event
            await anyio.sleep(RETRY)
    return found


async def is_proven(session: AsyncSession, key: str, keys: Keys) -> bool:
    """Whether another session proves that it has keys of the same name.

    Args:
        session: Session that reaches the other.
        key: Key of the challenge.
        keys: Keys with the name.
    """
    from seoro.security.keys.errors import InvalidKeys  # noqa: PLC0415 - only where there are keys
    from seoro.security.signing.commands import CommandSigner  # noqa: PLC0415 - the same

    nonce, sent = secrets.token_bytes(16), time.time_ns()
    try:
        answers = await session.query_others(key, encode(Challenge(nonce=nonce)), LIST_TIMEOUT)
    except SessionError:
        return False
    signer = CommandSigner(keys, keys.identity.name, keys.identity.role)
    for answer in answers:
        try:
            proof = decode(Proof, answer)
            times = (sent, time.time_ns())
            signer.accept(proof.certificate, proof.signature, nonce, proof.boot, proof.now, times, proof.exchange)
        except (WireError, InvalidKeys):
            continue
        return True
    return False
