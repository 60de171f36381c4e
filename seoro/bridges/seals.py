"""Requests to executors and nodes where there are keys: with seals, and with authentic answers."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

from seoro.bridges.session import Answer, AsyncSession, Check, Form, NoAnswer, NotAuthentic, Refused, form_of
from seoro.bridges.wire.holding import Holder
from seoro.bridges.wire.keys import NAMESPACE, executor_command, node_command
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.message import WireError, encode
from seoro.bridges.wire.proving import CHALLENGE, DENIED, UNAVAILABLE, Challenge, is_open
from seoro.bridges.wire.refusal import said_in
from seoro.bridges.wire.results import LabResult, Result
from seoro.errors import BackendRefused
from seoro.keys.errors import InvalidKeys
from seoro.keys.roles import MOVING, Role, executor_verbs, least_role

if TYPE_CHECKING:
    from seoro.keys import answers
    from seoro.keys.folder import Keys
    from seoro.keys.sealing import Sealer

TIMEOUT: Final = 5.0  # [s]


@dataclass(frozen=True)
class Peer:
    """Who is asked: an executor or a node, by its name."""

    name: str
    role: Role

    def __str__(self) -> str:
        return f"the {self.role.value} '{self.name}'"

    def key(self, verb: str) -> str:
        """On which it is asked for a verb."""
        command = node_command if self.role is Role.NODE else executor_command
        return command(NAMESPACE, self.name, verb)

    def lets(self, role: Role, verb: str) -> bool:
        """Whether those of a role may ask it for a verb."""
        if self.role is Role.NODE:
            return role in MOVING or is_open(verb)
        return verb in executor_verbs(role)

    @property
    def busy(self) -> int:
        """The code of its refusal of one who has to ask again later."""
        return LabResult.UNAVAILABLE if self.role is Role.NODE else UNAVAILABLE

    def least(self, verb: str) -> Role:
        """The least role that may."""
        return Role.OPERATOR if self.role is Role.NODE else least_role(verb)


@dataclass(frozen=True)
class Prepared:
    """A request that can be sent.

    Attributes:
        beside: What travels beside it; None for nothing.
        check: Checks its answers.
    """

    beside: bytes | None = None
    check: Check = form_of


class Seals:
    """Seals what is said to an executor or a node, and checks that its answers are authentic.

    Args:
        session: That reaches it.
        peer: Who it is.
        keys: Of who asks.
        is_required: Whether one without keys is not to be trusted; if it is, commands go to it without seals.
    """

    def __init__(self, session: AsyncSession, peer: Peer, keys: Keys, is_required: bool) -> None:
        self._session = session
        self.peer = peer
        self._keys = keys
        self._is_required = is_required
        self._sealer: Sealer | None = None
        self._has_keys = True

    def forget(self) -> None:
        """It was started anew, or its clock was set."""
        self._sealer = None

    async def prove(self) -> None:
        """Have it prove that it is the one of its name.

        Raises:
            NotAuthentic: It is not.
            SessionError: It does not answer, or is busy.
        """
        if self._sealer is None and self._has_keys:
            self._sealer = await self._challenge()

    async def prepare(self, verb: str, key: str, payload: bytes, sender: bytes | None) -> Prepared:
        """Prepare a request, so that its answer is authentic.

        Args:
            verb: What is asked for.
            key: Its key.
            payload: The request.
            sender: Name of who asks, with a code instead of a seal; empty for nobody, None for a seal.

        Raises:
            As `seal`.
        """
        inner = await self.seal(verb, key, payload) if sender is None else sender
        if not self._proves_later(verb):
            await self.prove()
        if not self._has_keys:
            return Prepared(inner or None)
        beside, check = self._checker.prepare(key, payload, inner or b"", has_code=bool(sender))
        return Prepared(beside, _Answers(self, verb, check))

    def identify(self, holder: Holder) -> Holder:
        """Add to a request for robots what authenticates the later requests of who holds them."""
        public, number = self._checker.holder_key()
        return holder.model_copy(update={"exchange": public, "number": number})

    @cached_property
    def _checker(self) -> answers.Checker:
        from seoro.keys.answers import Checker  # noqa: PLC0415 - only where there are keys

        return Checker(self._keys, self.peer.name, self.peer.role)

    async def seal(self, verb: str, key: str, payload: bytes) -> bytes | None:
        """The seal of a command; None if whom it is for has no keys, and need not have any.

        An emergency stop to a node is sealed before that has proven anything: it must not wait.

        Raises:
            BackendRefused: These keys may not say that.
            SessionError: It does not answer, is busy, or is not who it says.
        """
        self.check(verb)
        if self._proves_later(verb):
            from seoro.keys.sealing import seal_urgently  # noqa: PLC0415 - only where there are keys

            return seal_urgently(self._keys, key, payload)
        await self.prove()
        return None if self._sealer is None else self._sealer.seal(key, payload)

    def _proves_later(self, verb: str) -> bool:
        """Whether nobody waits for a proof before a request, because its answer is one."""
        return verb == EMERGENCY_STOP.name and self.peer.role is Role.NODE

    def check(self, verb: str) -> None:
        """Refuse what these keys may not say.

        Raises:
            BackendRefused: They may not.
        """
        identity = self._keys.identity
        if not self.peer.lets(identity.role, verb):
            least = self.peer.least(verb).value
            raise BackendRefused(
                f"the keys here are those of {identity}: `{verb}` is for one who is {least}", DENIED
            )

    async def _challenge(self) -> Sealer | None:
        from seoro.keys.sealing import NONCE, Sealer  # noqa: PLC0415 - the same

        nonce, sealer = secrets.token_bytes(NONCE), Sealer(self._keys, self.peer.name, self.peer.role)
        asked = time.time_ns()
        try:
            said = await self._session.query(
                self.peer.key(CHALLENGE.name), encode(Challenge(nonce=nonce)), TIMEOUT
            )
            proof = CHALLENGE.read_answer(said)
            given = (proof.certificate, proof.signature, nonce, proof.boot, proof.now)
            peer = sealer.accept(*given, (asked, time.time_ns()), proof.exchange)
            self._checker.share(peer, proof.boot, proof.exchange)
        except Refused as refused:
            reason = said_in(refused.payload)
            if reason.code == Result.FEATURE_UNSUPPORTED:
                if not self._is_required:
                    self._has_keys = False
                    return None
                raise NotAuthentic(
                    f"{self.peer} is not to be trusted: it does not prove who it is; start it with keys"
                ) from None
            raise NoAnswer(f"{self.peer} does not prove who it is: {reason.message}") from None
        except (WireError, InvalidKeys) as error:
            raise NotAuthentic(f"{self.peer} is not to be trusted: {error}") from None
        return sealer


class _Answers:
    """Checks the answers to one request.

    Args:
        seals: By which it was prepared.
        verb: What was asked for.
        check: Checks an answer and what came beside it.
    """

    def __init__(self, seals: Seals, verb: str, check: answers.Check) -> None:
        self._seals = seals
        self._verb = verb
        self._check = check
        self._next = 0  # number of the next answer

    def __call__(self, answer: Answer) -> Form:
        """Return the form of an answer.

        Raises:
            NotAuthentic: It is by another, was changed, or came before.
            NoAnswer: A part before it was lost.
        """
        if not answer.is_ok:
            return self._unsigned(answer.payload)
        try:
            checked = self._check(answer.payload, answer.beside)
            form = Form(checked.form)
        except (InvalidKeys, ValueError) as error:
            raise self._doubt(f"{error}") from None
        if checked.number < self._next:
            raise self._doubt("it came before")
        if checked.number > self._next:
            raise NoAnswer(f"a part of the answer of {self._seals.peer} to `{self._verb}` was lost")
        self._next += 1
        if checked.is_signed:
            self._seals.forget()  # it was started anew, or has not proven anything yet
        return form

    def _unsigned(self, payload: bytes) -> Form:
        """Form of what is refused before it is read, which nobody signs: asking again later harms nobody."""
        said = said_in(payload)
        if said.code == self._seals.peer.busy:
            return Form.REFUSAL
        raise self._doubt(f"it is not signed, and says: {said.message}")

    def _doubt(self, why: str) -> NotAuthentic:
        peer = self._seals.peer
        return NotAuthentic(
            f"the answer of {peer} to `{self._verb}` is not authentic: {why}; expected an answer by the keys of "
            f"{peer.name} ({peer.role.value}): find out what else answers on the routers in between"
        )


def node_seals(session: AsyncSession, name: str, keys: Keys | None) -> Seals | None:
    """What seals commands to a node; None where there are no keys."""
    return None if keys is None else Seals(session, Peer(name, Role.NODE), keys, is_required=True)
