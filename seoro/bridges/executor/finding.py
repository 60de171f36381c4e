"""Which executors there are, and whether they can be spoken with: tokens tell the version of what they say."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import anyio

from seoro import __version__
from seoro.bridges.executor.asking import Executor
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import MAJOR, NAMESPACE, any_executor_tokens, executor_tokens, token_major, token_node
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

TIMEOUT: Final = 2.0  # [s]
LOOK_AGAIN: Final = 0.05  # [s] between two looks for executors


async def find_executors(
    session: AsyncSession, keys: Keys | None = None, *, is_secured: bool = False
) -> list[Executor]:
    """All executors that a session reaches, by their names; waits a little for the first. See `Executor`.

    Raises:
        InvalidUse: There are some, of other versions only.
    """
    found: frozenset[str] = frozenset()
    with anyio.move_on_after(TIMEOUT):
        while True:
            found = await session.list_tokens(executor_tokens(NAMESPACE), TIMEOUT)
            if found:
                break
            await anyio.sleep(LOOK_AGAIN)
    if not found:
        await _refuse_strangers(session, None)
    named = sorted(dict(map(_named, found)).items())
    return [Executor(session, name, minor, keys, is_secured=is_secured) for name, minor in named]


async def find_executor(
    session: AsyncSession, name: str, keys: Keys | None = None, *, is_secured: bool = False
) -> Executor:
    """The executor of a name, which is waited for a little: it may be about to start. See `Executor`.

    Raises:
        InvalidUse: There is none, or it is of another version.
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
    raise InvalidUse(
        f"there is no executor '{name}' here",
        help=f"there are {known}" if known else how_to_see_some(f"seoro serve --name {name}", is_secured),
    )


async def _refuse_strangers(session: AsyncSession, name: str | None) -> None:
    """Refuse executors, or that of a name, that speak in another way."""
    for token in sorted(await session.list_tokens(any_executor_tokens(NAMESPACE), TIMEOUT)):
        found, major = token_node(token)[0], token_major(token)
        if major != str(MAJOR) and name in (None, found):
            raise InvalidUse(
                f"the executor '{found}' is of another version of seoro: it speaks version {major} of the "
                f"protocol, and this seoro ({__version__}) speaks {MAJOR}",
                help="use the same version of seoro on both sides",
            )


def _named(token: str) -> tuple[str, int]:
    """Name and minor version of an executor; the first ones told none."""
    name, boot = token_node(token)
    minor, dash, _ = boot.partition("-")
    return name, int(minor) if dash and minor.isdecimal() else 0


def _names(tokens: Iterable[str]) -> list[str]:
    return sorted({token_node(token)[0] for token in tokens})


def how_to_see_some(start: str, is_secured: bool) -> str:
    """What to do when there is no executor: those whose keys are revoked see none."""
    unseen = "; whose keys are revoked sees none" if is_secured else ""
    return f"start it with `{start}`{unseen}"
