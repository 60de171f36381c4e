"""Asking an executor. All that it is asked for can be asked again, so that a lost answer costs time only."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.executor.messages import STALE, UNAVAILABLE
from seoro.bridges.executor.seals import Seals
from seoro.bridges.session import AsyncSession, NoAnswer, NoServer, Refused, SessionError
from seoro.bridges.wire.keys import NAMESPACE, executor_command
from seoro.bridges.wire.message import A, Q, Verb, WireError, decode, encode
from seoro.bridges.wire.refusal import said_in
from seoro.errors import BackendLost, BackendRefused

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

TIMEOUT: Final = 5.0  # [s] for one answer, beside what the executor is asked to wait
PATIENCE: Final = 300.0  # [s] for which it is asked again
FIRST_PAUSE: Final = 0.05  # [s] before it is asked again; doubles
LONGEST_PAUSE: Final = 1.0  # [s]


class ExecutorLost(BackendLost):
    """The executor is gone, or cannot be reached any more."""


class _Unavailable(Exception):
    """The executor is there, and cannot answer now."""


class Executor:
    """An executor that can be asked.

    Args:
        session: That reaches it.
        name: Its name.
        minor: Of the version of what it says; `messages.MINOR` is ours.
        keys: What to seal commands with.
        is_secured: Whether the executor has to have keys, too.

    `on_silence` is called when it does not answer, and `on_answer` when it does again.
    """

    def __init__(
        self, session: AsyncSession, name: str, minor: int, keys: Keys | None = None, *, is_secured: bool = False
    ) -> None:
        self._session = session
        self.name = name
        self.minor = minor
        self._seals = None if keys is None else Seals(session, name, keys, is_secured)
        self.patience = PATIENCE
        self.on_silence: Callable[[str], object] = lambda reason: None
        self.on_answer: Callable[[], object] = lambda: None

    async def ask(self, verb: Verb[Q, A], request: Q, wait: float = 0.0) -> A:
        """Ask for something, again and again while there is no answer.

        Args:
            verb: What is asked for.
            request: The same in full.
            wait: How long the executor may wait before it answers [s].

        Raises:
            BackendRefused: It said no, or the keys are not for that.
            ExecutorLost: It has not answered for as long as it is waited for.
        """
        began, pause, is_silent = time.monotonic(), FIRST_PAUSE, False
        while True:
            try:
                answer = await self._ask_once(verb, request, wait)
            except (SessionError, _Unavailable) as error:
                if time.monotonic() - began > self.patience:
                    raise ExecutorLost(self._lost(error)) from None
                if not is_silent:
                    is_silent = True
                    self.on_silence(self._lost(error))
                await anyio.sleep(pause)
                pause = min(2.0 * pause, LONGEST_PAUSE)
            else:
                if is_silent:
                    self.on_answer()
                return answer

    def _lost(self, error: SessionError | _Unavailable) -> str:
        match error:
            case NoServer():
                return f"the executor '{self.name}' is gone, or the connection to it is lost"
            case NoAnswer():
                return f"the executor '{self.name}' does not answer"
            case _:
                return f"the executor '{self.name}' cannot be asked: {error}"

    async def _ask_once(self, verb: Verb[Q, A], request: Q, wait: float) -> A:
        key = executor_command(NAMESPACE, self.name, verb.name)
        payload = encode(request)
        seal = None if self._seals is None else await self._seals.seal(verb.name, key, payload)
        try:
            return decode(verb.answer, await self._session.query(key, payload, wait + TIMEOUT, seal))
        except Refused as refused:
            said = said_in(refused.payload)
            if said.code == STALE and self._seals is not None:
                self._seals.forget()
                raise _Unavailable(said.message) from None
            if said.code == UNAVAILABLE:
                raise _Unavailable(said.message) from None
            raise BackendRefused(said.message, said.code) from None
        except WireError as error:
            raise ExecutorLost(f"the executor '{self.name}' sent an answer that is none: {error}") from error
