"""The keys of an executor or a node: they prove who it is, and tell who others are."""

from __future__ import annotations

import secrets
import time

from seoro.bridges.ledger import Ledger
from seoro.bridges.revoked import Revoked
from seoro.bridges.session import Request
from seoro.bridges.wire.proving import DENIED, STALE, Challenge, Proof
from seoro.bridges.wire.refusal import RequestRefused
from seoro.keys.certificates import Identity
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.roles import Role
from seoro.keys.sealing import Stale, Verifier, certificate_der, prove


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
        self._boot = secrets.token_hex(8)  # which start of it this is
        self._verifier = Verifier(keys, self._boot, revoked.current)

    @property
    def role(self) -> Role:
        """As what it has its keys."""
        return self._keys.identity.role

    def prove(self, challenge: Challenge) -> Proof:
        """Answer a challenge."""
        now, name = time.time_ns(), self._keys.identity.name
        return Proof(
            certificate=certificate_der(self._keys.certificate),
            signature=prove(self._keys, name, challenge.nonce, self._boot, now),
            boot=self._boot,
            now=now,
        )

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
