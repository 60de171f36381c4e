"""The keys of an executor: they prove who it is, and tell who others are. Loaded only where there are keys."""

from __future__ import annotations

import secrets
import time

from seoro.bridges.executor import messages as wire
from seoro.bridges.revoked import Revoked
from seoro.bridges.session import Request
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.ledger import Ledger
from seoro.keys.certificates import Identity
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.sealing import Stale, Verifier, certificate_der, prove


class Lock:
    """Who is who.

    Args:
        keys: Of the executor.
        revoked: Who is revoked.
        ledger: Of what is asked.
    """

    def __init__(self, keys: Keys, revoked: Revoked, ledger: Ledger) -> None:
        self.ledger = ledger
        self._keys = keys
        self._boot = secrets.token_hex(8)  # which start of the executor this is
        self._revoked = revoked
        self._verifier = Verifier(keys, self._boot, revoked.current)

    def prove(self, challenge: wire.Challenge) -> wire.Proof:
        """Answer a challenge."""
        now, name = time.time_ns(), self._keys.identity.name
        return wire.Proof(
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
            raise RequestRefused(wire.STALE, str(error)) from error
        except InvalidKeys as error:
            raise RequestRefused(wire.DENIED, str(error)) from error

    def revoke(self, request: wire.Revoke) -> Empty:
        """Have a newer list of those who are revoked.

        Raises:
            RequestRefused: The authority has not signed it, or it is older.
        """
        try:
            self._revoked.take(request.data)
        except InvalidKeys as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        return Empty()
