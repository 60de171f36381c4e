"""Asking an executor. All that it is asked for can be asked again, so that a lost answer costs time only."""

from __future__ import annotations

import time
from collections.abc import AsyncGenerator, Callable
from typing import TYPE_CHECKING, Final, TypeVar

import anyio

from seoro.bridges.executor.messages import UNAVAILABLE
from seoro.bridges.seals import Peer, Prepared, Seals
from seoro.bridges.session import (
    AsyncSession,
    NoAnswer,
    NoServer,
    NotAuthentic,
    Refused,
    SessionError,
    asking_for_parts,
)
from seoro.bridges.wire.keys import NAMESPACE, executor_command
from seoro.bridges.wire.limits import Limits
from seoro.bridges.wire.message import A, M, Message, Q, Verb, WireError, decode, encode
from seoro.bridges.wire.proving import STALE
from seoro.bridges.wire.refusal import said_in
from seoro.errors import BackendLost, BackendRefused
from seoro.keys.roles import Role

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

P = TypeVar("P", bound=Message)

TIMEOUT: Final = 5.0  # [s] for one answer, beside what the executor is asked to wait
PATIENCE: Final = 300.0  # [s] for which it is asked again
FIRST_PAUSE: Final = 0.05  # [s] before it is asked again; doubles
LONGEST_PAUSE: Final = 1.0  # [s]


class ExecutorLost(BackendLost):
    """The executor is gone, or cannot be reached any more."""


class Unavailable(Exception):
    """There is no answer now: it may be asked again."""


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
        peer = Peer(name, Role.EXECUTOR)
        self._seals = None if keys is None else Seals(session, peer, keys, is_secured)
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
            ExecutorLost: It has not answered for as long as it is waited for, or another has answered for it.
        """
        began, pause, is_silent = time.monotonic(), FIRST_PAUSE, False
        while True:
            try:
                answer = await self._ask_once(verb, request, wait)
            except NotAuthentic as error:
                raise ExecutorLost(str(error)) from None
            except (SessionError, Unavailable) as error:
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

    async def ask_in_parts(
        self, verb: Verb[Q, A], part: type[P], request: Q, wait: float = 0.0
    ) -> AsyncGenerator[A | P, None]:
        """Ask for something once, and give the parts of the answer as they come, and then the answer.

        Args:
            verb: What is asked for.
            part: What parts are.
            request: The same in full.
            wait: How long the executor may wait before it has answered [s].

        Raises:
            Unavailable: There is no answer, or no more of it.
            BackendRefused: It said no.
            ExecutorLost: Another has answered for it, or the answer was changed.
        """
        key = executor_command(NAMESPACE, self.name, verb.name)
        payload = encode(request)
        try:
            asked = await self._prepared(verb.name, key, payload)
            within = wait + TIMEOUT
            async with asking_for_parts(self._session, key, payload, within, asked.beside, asked.check) as parts:
                async for is_part, said in parts:
                    yield self._decoded(part if is_part else verb.answer, said, verb.answers)
        except Refused as refused:
            raise self._refusal(refused) from None
        except NotAuthentic as error:
            raise ExecutorLost(str(error)) from None
        except SessionError as error:
            raise Unavailable(str(error)) from None

    def _lost(self, error: SessionError | Unavailable) -> str:
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
        asked = await self._prepared(verb.name, key, payload)
        try:
            answer = await self._session.query(
                key, payload, wait + TIMEOUT, asked.beside, check=asked.check, is_urgent=verb.is_urgent
            )
            return self._decoded(verb.answer, answer, verb.answers)
        except Refused as refused:
            raise self._refusal(refused) from None

    async def _prepared(self, verb: str, key: str, payload: bytes) -> Prepared:
        return Prepared() if self._seals is None else await self._seals.prepare(verb, key, payload, None)

    def _decoded(self, kind: type[M], answer: bytes, limits: Limits) -> M:
        try:
            return decode(kind, answer, limits)
        except WireError as error:
            raise ExecutorLost(f"the executor '{self.name}' sent an answer that is none: {error}") from error

    def _refusal(self, refused: Refused) -> Exception:
        said = said_in(refused.payload)
        if said.code == STALE and self._seals is not None:
            self._seals.forget()
            return Unavailable(said.message)
        return Unavailable(said.message) if said.code == UNAVAILABLE else BackendRefused(said.message, said.code)
