"""The keys of an executor or a node: they prove who it is, and tell who others are."""

from __future__ import annotations

import secrets
from typing import Any, Final

from seoro.bridges.ledger import Ledger
from seoro.bridges.revoked import Revoked
from seoro.bridges.session import Request
from seoro.bridges.wire.proving import DENIED, STALE, Challenge, Proof
from seoro.bridges.wire.refusal import RequestRefused
from seoro.keys.answers import Answers
from seoro.keys.certificates import Identity
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.roles import Role
from seoro.keys.sealing import Stale, Verifier, prove
from seoro.keys.signing import Signatures, certificate_der, sign
from seoro.steady import steady_ns


class Lock:
    """Who is who.

    Args:
        keys: Of the executor or the node.
        revoked: Who is revoked.
        ledger: Of what is asked.
    """

    def __init__(self, keys: Keys, revoked: Revoked, ledger: Ledger) -> None:
        self.ledger = ledger
        self.revoked = revoked
        self._keys = keys
        self.boot: Final = secrets.token_hex(8)  # which start of it this is
        self._verifier = Verifier(keys, self.boot, revoked.current)
        self._signatures = Signatures(keys.authority, revoked.current)
        self.answers: Final = Answers(keys, self.boot)

    @property
    def role(self) -> Role:
        """As what it has its keys."""
        return self._keys.identity.role

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

    def sign(self, *said: Any) -> bytes:
        """Sign a statement."""
        return sign(self._keys, *said)

    def is_own(self, signature: bytes, *said: Any) -> bool:
        """Whether a statement was signed with the keys of this name, here or elsewhere."""
        identity = self._keys.identity
        try:
            self._signatures.check(signature, identity.role, identity.name, *said)
        except InvalidKeys:
            return False
        return True

    def admit(self, request: Request) -> Identity:
        """Who has sent a request.

        Raises:
            RequestRefused: Nobody who may ask for anything.
        """
        try:
            return self._verifier.verify(request.key, request.payload, request.attachment)
        except Stale as error:
            raise RequestRefused(STALE, str(error)) from error
        except InvalidKeys as error:
            raise RequestRefused(DENIED, str(error)) from error

    def admit_urgent(self, key: str, payload: bytes, seal: bytes) -> Identity:
        """Who has sent an emergency stop.

        Raises:
            RequestRefused: Nobody whom it can be told of.
        """
        try:
            return self._verifier.verify_urgent(key, payload, seal)
        except InvalidKeys as error:
            raise RequestRefused(DENIED, str(error)) from error
