"""Discovery of executors by their liveliness tokens, which contain the version of their protocol."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.executor.asking import Executor
from seoro.bridges.naming import wait_for_tokens
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import MAJOR, NAMESPACE, any_executor_tokens, executor_tokens, token_major, token_node
from seoro.errors import UsageError

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

TIMEOUT: Final = 2.0  # [s]


async def find_executors(
    session: AsyncSession, keys: Keys | None = None, *, is_secured: bool = False
) -> list[Executor]:
    """Return all executors that a session reaches, sorted by name; waits up to `TIMEOUT` for the first.

    Args:
        session: The session.
        keys: See `Executor`.
        is_secured: See `Executor`.

    Raises:
        UsageError: All executors have other versions of the protocol.
    """
    found = await wait_for_tokens(session, executor_tokens(NAMESPACE), TIMEOUT)
    if not found:
        await _refuse_strangers(session, None)
    named = sorted(dict(map(_named, found)).items())
    return [Executor(session, name, minor, keys, is_secured=is_secured) for name, minor in named]


async def find_executor(
    session: AsyncSession, name: str, keys: Keys | None = None, *, is_secured: bool = False
) -> Executor:
    """Return the executor of a name; waits up to `TIMEOUT` for its start.

    Args:
        session: The session.
        name: Name of the executor.
        keys: See `Executor`.
        is_secured: See `Executor`.

    Raises:
        UsageError: The executor is missing, or has another version of the protocol.
    """
    others: set[str] = set()
    with anyio.move_on_after(TIMEOUT):
        async with session.tokens(executor_tokens(NAMESPACE)) as tokens:
            async for token, alive in tokens:
                if alive and token_node(token)[0] == name:
                    return Executor(session, *_named(token), keys, is_secured=is_secured)
                (others.add if alive else others.discard)(token)
    await _refuse_strangers(session, name)
    known = ", ".join(_names(others))
    raise UsageError(
        f"unknown executor '{name}'",
        help=f"executors: {known}" if known else start_hint(f"seoro serve --name {name}", is_secured),
    )


async def _refuse_strangers(session: AsyncSession, name: str | None) -> None:
    """Refuse an executor with another version of the protocol, of one name or, for None, of any."""
    for token in sorted(await session.list_tokens(any_executor_tokens(NAMESPACE), TIMEOUT)):
        found, major = token_node(token)[0], token_major(token)
        if major != str(MAJOR) and name in (None, found):
            raise UsageError(
                f"the executor '{found}' speaks version {major} of the protocol; expected version {MAJOR}",
                help="use the same version of seoro on both sides",
            )


def _named(token: str) -> tuple[str, int]:
    """Return the name and the minor version of an executor; 0 for versions without it."""
    name, boot = token_node(token)
    minor, dash, _ = boot.partition("-")
    return name, int(minor) if dash and minor.isdecimal() else 0


def _names(tokens: Iterable[str]) -> list[str]:
    return sorted({token_node(token)[0] for token in tokens})


def start_hint(start: str, is_secured: bool) -> str:
    """Return a hint to start an executor by a command."""
    unseen = "; clients with revoked keys see no executors" if is_secured else ""
    return f"start it with `{start}`{unseen}"
