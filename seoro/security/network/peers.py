"""Requests with keys: signed for one executor or node, whose answers are verified."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from seoro.bridges.session import Answer, AsyncSession, Check, Form, NoAnswer, NotAuthentic, Refused, form_of
from seoro.bridges.wire.authentication import CHALLENGE, DENIED, UNAVAILABLE, Challenge
from seoro.bridges.wire.holds import Holder
from seoro.bridges.wire.keys import NAMESPACE, executor_command, node_command
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.message import Verb, WireError, encode
from seoro.bridges.wire.refusal import read_refusal
from seoro.bridges.wire.results import LabResult, Result
from seoro.errors import BackendRefused
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.roles import MOVING, Role

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys
    from seoro.security.signing import answers
    from seoro.security.signing.commands import CommandSigner

TIMEOUT: Final = 5.0  # [s]


@dataclass(frozen=True)
class Peer:
    """Executor or node that receives requests, by its name."""

    name: str
    role: Role

    def __str__(self) -> str:
        return f"the {self.role.value} '{self.name}'"

    def key(self, verb: str) -> str:
        """Return the key for requests of a verb."""
        command = node_command if self.role is Role.NODE else executor_command
        return command(NAMESPACE, self.name, verb)

    def allows(self, role: Role, verb: Verb[Any, Any]) -> bool:
        """Whether clients of a role may send it a verb."""
        if self.role is Role.NODE:
            return role in MOVING or verb.is_public
        return role.includes(verb.role)

    @property
    def busy(self) -> int:
        """Code of its refusals that ask the client to retry later."""
        return LabResult.UNAVAILABLE if self.role is Role.NODE else UNAVAILABLE


@dataclass(frozen=True)
class PreparedRequest:
    """A request that is ready to be sent.

    Attributes:
        attachment: Attachment of the request; None for no attachment.
        check: Verifies its answers.
    """

    attachment: bytes | None = None
    check: Check = form_of


class PeerSigner:
    """Signs requests to one executor or node, and verifies its answers.

    Args:
        session: Session that reaches it.
        peer: The executor or node.
        keys: Keys of the client.
        is_required: Whether the peer must have keys; if not, a peer without keys gets unsigned requests.
    """

    def __init__(self, session: AsyncSession, peer: Peer, keys: Keys, is_required: bool) -> None:
        self._session = session
        self.peer = peer
        self._keys = keys
        self._is_required = is_required
        self._signer: CommandSigner | None = None
        self._has_keys = True

    def reset(self) -> None:
        """Challenge the peer again before the next request: it was restarted, or its clock was set."""
        self._signer = None

    async def verify_peer(self) -> None:
        """Challenge the peer to prove its name, unless it has done so before.

        Raises:
            NotAuthentic: The proof is invalid.
            SessionError: The peer does not answer, or is busy.
        """
        if self._signer is None and self._has_keys:
            self._signer = await self._challenge()

    async def prepare(
        self, verb: Verb[Any, Any], key: str, payload: bytes, sender: bytes | None
    ) -> PreparedRequest:
        """Prepare a request whose answer can be verified.

        Args:
            verb: Verb of the request.
            key: Key of the request.
            payload: The request.
            sender: Name of a client that holds robots, authenticated by a code; empty for an anonymous request,
                None for a signed one.

        Raises:
            As `sign`.
        """
        inner = await self.sign(verb, key, payload) if sender is None else sender
        if not self._proves_later(verb):
            await self.verify_peer()
        if not self._has_keys:
            return PreparedRequest(inner or None)
        attachment, check = self._checker.prepare(key, payload, inner or b"", has_code=bool(sender))
        return PreparedRequest(attachment, _Answers(self, verb.name, check))

    def add_holder_key(self, holder: Holder) -> Holder:
        """Add the public key that authenticates later requests of a holder of robots."""
        public, number = self._checker.holder_key()
        return holder.model_copy(update={"exchange": public, "number": number})

    @cached_property
    def _checker(self) -> answers.AnswerVerifier:
        from seoro.security.signing.answers import AnswerVerifier  # noqa: PLC0415 - only where there are keys

        return AnswerVerifier(self._keys, self.peer.name, self.peer.role)

    async def sign(self, verb: Verb[Any, Any], key: str, payload: bytes) -> bytes | None:
        """Return the signature of a request; None if the peer has no keys and needs none.

        An emergency stop to a node is signed without a challenge: it must not wait.

        Raises:
            BackendRefused: The role of these keys may not send the verb.
            SessionError: The peer does not answer, is busy, or fails to prove its name.
        """
        self.check_role(verb)
        if self._proves_later(verb):
            from seoro.security.signing.commands import sign_emergency_stop  # noqa: PLC0415 - only where there are keys

            return sign_emergency_stop(self._keys, key, payload)
        await self.verify_peer()
        return None if self._signer is None else self._signer.sign(key, payload)

    def _proves_later(self, verb: Verb[Any, Any]) -> bool:
        """Whether a request is sent without a proof of the peer, because the answer is signed."""
        return verb is EMERGENCY_STOP and self.peer.role is Role.NODE

    def check_role(self, verb: Verb[Any, Any]) -> None:
        """Check that the role of these keys may send a verb.

        Raises:
            BackendRefused: It may not.
        """
        identity = self._keys.identity
        if not self.peer.allows(identity.role, verb):
            raise BackendRefused(
                f"{identity} may not send `{verb.name}` (required role: {verb.role.value})", DENIED
            )

    async def _challenge(self) -> CommandSigner | None:
        from seoro.security.signing.commands import NONCE, CommandSigner  # noqa: PLC0415 - the same

        nonce, signer = secrets.token_bytes(NONCE), CommandSigner(self._keys, self.peer.name, self.peer.role)
        asked = time.time_ns()
        try:
            reply = await self._session.query(
                self.peer.key(CHALLENGE.name), encode(Challenge(nonce=nonce)), TIMEOUT
            )
            proof = CHALLENGE.read_reply(reply)
            given = (proof.certificate, proof.signature, nonce, proof.boot, proof.now)
            peer = signer.accept(*given, (asked, time.time_ns()), proof.exchange)
            self._checker.share(peer, proof.boot, proof.exchange)
        except Refused as refused:
            reason = read_refusal(refused.payload)
            if reason.code == Result.FEATURE_UNSUPPORTED:
                if not self._is_required:
                    self._has_keys = False
                    return None
                raise NotAuthentic(
                    f"untrusted: {self.peer} does not prove its identity; start it with keys"
                ) from None
            raise NoAnswer(f"{self.peer} does not prove its identity: {reason.message}") from None
        except (WireError, InvalidKeys) as error:
            raise NotAuthentic(f"untrusted: {self.peer}: {error}") from None
        return signer


class _Answers:
    """Verifies the answers to one request.

    Args:
        signer: Signer that prepared the request.
        verb: Verb of the request.
        check: Verifies an answer with its attachment.
    """

    def __init__(self, signer: PeerSigner, verb: str, check: answers.Check) -> None:
        self._signer = signer
        self._verb = verb
        self._check = check
        self._next = 0  # number of the next answer

    def __call__(self, answer: Answer) -> Form:
        """Return the form of an answer.

        Raises:
            NotAuthentic: The answer is from another sender, changed, or a repetition.
            NoAnswer: A previous part was lost.
        """
        if not answer.is_ok:
            return self._unsigned(answer.payload)
        try:
            checked = self._check(answer.payload, answer.attachment)
            form = Form(checked.form)
        except (InvalidKeys, ValueError) as error:
            raise self._not_authentic(f"{error}") from None
        if checked.number < self._next:
            raise self._not_authentic("it was received before")
        if checked.number > self._next:
            raise NoAnswer(f"a part of the answer of {self._signer.peer} to `{self._verb}` was lost")
        self._next += 1
        if checked.is_signed:
            self._signer.reset()  # the peer was restarted, or has not proven its name yet
        return form

    def _unsigned(self, payload: bytes) -> Form:
        """Accept an unsigned refusal only if it asks to retry later, which is harmless."""
        refusal = read_refusal(payload)
        if refusal.code == self._signer.peer.busy:
            return Form.REFUSAL
        raise self._not_authentic(f"unsigned refusal: {refusal.message}")

    def _not_authentic(self, why: str) -> NotAuthentic:
        peer = self._signer.peer
        return NotAuthentic(
            f"the answer of {peer} to `{self._verb}` is not authentic: {why}; expected an answer signed with the "
            f"keys of {peer.name} ({peer.role.value}): check what else answers over the same routers"
        )


def node_signer(session: AsyncSession, name: str, keys: Keys | None) -> PeerSigner | None:
    """Return the signer of requests to a node; None without keys."""
    return None if keys is None else PeerSigner(session, Peer(name, Role.NODE), keys, is_required=True)
