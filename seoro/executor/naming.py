"""There is one executor of a name: who asks for it must not reach now one and now another."""

from __future__ import annotations

import logging
import secrets
import time

from seoro.bridges.executor.messages import MINOR
from seoro.bridges.naming import becomes_free, holders
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import NAMESPACE, executor_token, executor_tokens_of, token_node
from seoro.errors import InvalidUse

log = logging.getLogger(__name__)


async def await_name(session: AsyncSession, name: str) -> None:
    """Wait a little until nobody has a name, to be called before anything is served under it.

    Raises:
        InvalidUse: Somebody has it.
    """
    if not await becomes_free(session, executor_tokens_of(NAMESPACE, name)):
        raise _taken(name)


def draw_token(name: str) -> str:
    """The token of a start of an executor. Of those of one name, that of who has started first is the least.

    When that was is a matter of each machine's own clock: what counts is that all come to the same conclusion.
    """
    return executor_token(NAMESPACE, name, f"{MINOR}-{time.time_ns() // 1_000_000:012x}{secrets.token_hex(8)}")


async def check_first(session: AsyncSession, token: str) -> None:
    """Check that nobody has come to have the name at the same moment, once the token is there.

    Of two, one goes on.

    Raises:
        InvalidUse: Somebody has, and is first.
    """
    name, _ = token_node(token)
    if min({token, *await holders(session, executor_tokens_of(NAMESPACE, name))}) != token:
        raise _taken(name)


async def wait_for_elder(session: AsyncSession, token: str) -> None:
    """Wait until an executor of the same name is reached that has started before this one.

    Two have a name when the second one started while the first could not be reached.
    """
    name, _ = token_node(token)
    async with session.tokens(executor_tokens_of(NAMESPACE, name)) as changes:
        async for other, is_alive in changes:
            if is_alive and other < token:
                return
            if is_alive and other > token:
                log.warning("another executor '%s', which has started after this one, gives the name up", name)


def name_given_up(name: str) -> str:
    """Why an executor ends that has met one of its name which has started before it."""
    return f"another executor '{name}', which has started before this one, is reached again, and has the name"


def _taken(name: str) -> InvalidUse:
    return InvalidUse(f"there is an executor '{name}' already", help="`--name` gives this one another name")
