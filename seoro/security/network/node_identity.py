"""Identity of an executor or a node: proves its own name, and verifies the senders of requests."""

from __future__ import annotations

import secrets
from typing import Any, Final

from seoro.bridges.session import Request
from seoro.bridges.wire.authentication import DENIED, STALE, Challenge, Proof
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.steady_clock import steady_ns
from seoro.security.keys.certificates import Identity
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.network.audit_trail import AuditTrail
from seoro.security.network.revocation_monitor import RevocationMonitor
from seoro.security.signing.answers import AnswerSigner
from seoro.security.signing.commands import CommandVerifier, StaleCommand, prove
from seoro.security.signing.statements import StatementVerifier, certificate_der, sign


class NodeIdentity:
    """Keys of a server, with everything that depends on them.

    Args:
        keys: Keys of the executor or the node.
        revoked: Revoked keys.
        audit_trail: Record of its requests.

    Attributes:
        boot: Random identifier of this start of the server.
        answers: Authenticates its answers.
    """

    def __init__(self, keys: Keys, revoked: RevocationMonitor, audit_trail: AuditTrail) -> None:
        self.audit_trail = audit_trail
        self.revoked = revoked
        self._keys = keys
        self.role: Final = keys.identity.role
        self.boot: Final = secrets.token_hex(8)
        self._verifier = CommandVerifier(keys, self.boot, revoked.current)
        self._signatures = StatementVerifier(keys.authority, revoked.current)
        self.answers: Final = AnswerSigner(keys, self.boot)

    def prove(self, challenge: Challenge) -> Proof:
        """Answer a challenge."""
        now, name, exchange = steady_ns(), self._keys.identity.name, self.answers.exchange
        return Proof(
            certificate=certificate_der(self._keys.certificate),
            signature=prove(self._keys, name, challenge.nonce, self.boot, now, exchange),
            boot=self.boot,
            now=now,
            exchange=exchange,
        )

    def sign(self, *statement: Any) -> bytes:
        """Sign the parts of a statement."""
        return sign(self._keys, *statement)

    def is_own_signature(self, signature: bytes, *statement: Any) -> bool:
        """Whether a statement was signed by keys of this name and role."""
        identity = self._keys.identity
        try:
            self._signatures.check(signature, identity.role, identity.name, *statement)
        except InvalidKeys:
            return False
        return True

    def authenticate(self, request: Request) -> Identity:
        """Return the sender of a signed request.

        Raises:
            RequestRefused: The signature is invalid, revoked or stale.
        """
        try:
            return self._verifier.verify(request.key, request.payload, request.attachment)
        except StaleCommand as error:
            raise RequestRefused(STALE, str(error)) from error
        except InvalidKeys as error:
            raise RequestRefused(DENIED, str(error)) from error

    def authenticate_stop(self, key: str, payload: bytes, signature: bytes) -> Identity:
        """Return the sender of an emergency stop.

        Raises:
            RequestRefused: The signature is invalid or revoked, or the stop was received before.
        """
        try:
            return self._verifier.verify_stop(key, payload, signature)
        except InvalidKeys as error:
            raise RequestRefused(DENIED, str(error)) from error
