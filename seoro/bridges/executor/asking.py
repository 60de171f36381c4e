"""Requests to an executor. All of them may be repeated, so that a lost reply costs only time."""

from __future__ import annotations

import time
from collections.abc import AsyncGenerator, Callable
from typing import TYPE_CHECKING, Any, Final, TypeVar

import anyio

from seoro.bridges.executor.messages import UNAVAILABLE
from seoro.bridges.session import (
    AsyncSession,
    NoAnswer,
    NoServer,
    NotAuthentic,
    Refused,
    SessionError,
    query_parts,
)
from seoro.bridges.wire.authentication import STALE
from seoro.bridges.wire.keys import NAMESPACE, executor_command
from seoro.bridges.wire.limits import Limits
from seoro.bridges.wire.message import A, M, Message, Q, Verb, WireError, decode, encode
from seoro.bridges.wire.refusal import read_refusal
from seoro.errors import BackendLost, BackendRefused
from seoro.security.keys.roles import Role
from seoro.security.network.peers import Peer, PeerSigner, PreparedRequest

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

P = TypeVar("P", bound=Message)

TIMEOUT: Final = 5.0  # [s] for a reply, in addition to the wait of the executor
PATIENCE: Final = 300.0  # [s] for which requests are repeated
FIRST_PAUSE: Final = 0.05  # [s] before the first repetition; doubles
LONGEST_PAUSE: Final = 1.0  # [s]


class ExecutorLost(BackendLost):
    """The executor ended, or is unreachable."""


class Unavailable(Exception):
    """The reply is missing; the request may be repeated."""


class Executor:
    """An executor that receives requests.

    Args:
        session: Session that reaches the executor.
        name: Name of the executor.
        minor: Minor version of its protocol; ours is `messages.MINOR`.
        keys: Keys that sign requests; None for unsigned requests.
        is_secured: Whether the executor must have keys, too.

    Attributes:
        patience: Time for which requests are repeated [s].
        on_silence: Called with the reason when replies are missing.
        on_answer: Called at the next reply.
    """

    def __init__(
        self, session: AsyncSession, name: str, minor: int, keys: Keys | None = None, *, is_secured: bool = False
    ) -> None:
        self._session = session
        self.name = name
        self.minor = minor
        peer = Peer(name, Role.EXECUTOR)
        self._signer = None if keys is None else PeerSigner(session, peer, keys, is_secured)
        self.patience = PATIENCE
        self.on_silence: Callable[[str], object] = lambda reason: None
        self.on_answer: Callable[[], object] = lambda: None

    async def ask(self, verb: Verb[Q, A], request: Q, wait: float = 0.0) -> A:
        """Send a request, and repeat it until the reply; returns the reply.

        Args:
            verb: Verb of the request.
            request: The request.
            wait: Time for which the executor may delay the reply [s].

        Raises:
            BackendRefused: The executor refuses the request, or the keys here do not permit it.
            ExecutorLost: The executor does not reply within `patience`, or the reply is not authentic.
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
        """Send a request once; yields the parts of the reply as they arrive, and then the reply.

        Args:
            verb: Verb of the request.
            part: Model of parts.
            request: The request.
            wait: Time for which the executor may delay the end of the reply [s].

        Raises:
            Unavailable: The reply or a part of it is missing.
            BackendRefused: The executor refuses the request.
            ExecutorLost: The reply is not authentic.
        """
        key = executor_command(NAMESPACE, self.name, verb.name)
        payload = encode(request)
        try:
            prepared = await self._prepare(verb, key, payload)
            within, attachment, check = wait + TIMEOUT, prepared.attachment, prepared.check
            async with query_parts(self._session, key, payload, within, attachment, check) as parts:
                async for is_part, data in parts:
                    yield self._decode(part if is_part else verb.reply, data, verb.reply_limits)
        except Refused as refused:
            raise self._refusal(refused) from None
        except NotAuthentic as error:
            raise ExecutorLost(str(error)) from None
        except SessionError as error:
            raise Unavailable(str(error)) from None

    def _lost(self, error: SessionError | Unavailable) -> str:
        match error:
            case NoServer():
                return f"the executor '{self.name}' ended, or the connection to it is lost"
            case NoAnswer():
                return f"the executor '{self.name}' does not answer"
            case _:
                return f"cannot reach the executor '{self.name}': {error}"

    async def _ask_once(self, verb: Verb[Q, A], request: Q, wait: float) -> A:
        key = executor_command(NAMESPACE, self.name, verb.name)
        payload = encode(request)
        prepared = await self._prepare(verb, key, payload)
        try:
            answer = await self._session.query(
                key, payload, wait + TIMEOUT, prepared.attachment, check=prepared.check, is_urgent=verb.is_urgent
            )
            return self._decode(verb.reply, answer, verb.reply_limits)
        except Refused as refused:
            raise self._refusal(refused) from None

    async def _prepare(self, verb: Verb[Any, Any], key: str, payload: bytes) -> PreparedRequest:
        return PreparedRequest() if self._signer is None else await self._signer.prepare(verb, key, payload, None)

    def _decode(self, kind: type[M], answer: bytes, limits: Limits) -> M:
        try:
            return decode(kind, answer, limits)
        except WireError as error:
            raise ExecutorLost(f"the executor '{self.name}' sent an invalid answer: {error}") from error

    def _refusal(self, refused: Refused) -> Exception:
        refusal = read_refusal(refused.payload)
        if refusal.code == STALE and self._signer is not None:
            self._signer.reset()
            return Unavailable(refusal.message)
        if refusal.code == UNAVAILABLE:
            return Unavailable(refusal.message)
        return BackendRefused(refusal.message, refusal.code)
