"""Commands to an executor with seals, where there are keys."""

from __future__ import annotations

import secrets
import time
from typing import TYPE_CHECKING, Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.session import AsyncSession, Refused
from seoro.bridges.wire.keys import NAMESPACE, executor_command
from seoro.bridges.wire.message import WireError, decode, encode
from seoro.bridges.wire.refusal import said_in
from seoro.bridges.wire.results import Result
from seoro.errors import BackendRefused
from seoro.keys.roles import executor_verbs, least_role

if TYPE_CHECKING:
    from seoro.keys.folder import Keys
    from seoro.keys.sealing import Sealer

TIMEOUT: Final = 5.0  # [s]


class Seals:
    """Seals what a client says to an executor.

    Args:
        session: That reaches it.
        executor: Its name.
        keys: Of the client.
        is_required: Whether one without keys is not to be trusted; if it is, commands go to it without seals.
    """

    def __init__(self, session: AsyncSession, executor: str, keys: Keys, is_required: bool) -> None:
        self._session = session
        self._executor = executor
        self._keys = keys
        self._is_required = is_required
        self._sealer: Sealer | None = None
        self._has_keys = True

    def forget(self) -> None:
        """The executor was started anew, or its clock was set."""
        self._sealer = None

    async def seal(self, verb: str, key: str, payload: bytes) -> bytes | None:
        """The seal of a command; None if the executor has no keys, and need not have any.

        Raises:
            BackendRefused: These keys may not say that, or the executor is not who it says.
            SessionError: It does not answer.
        """
        identity = self._keys.identity
        if verb not in executor_verbs(identity.role):
            raise BackendRefused(
                f"the keys here are those of {identity}: `{verb}` is for one who is {least_role(verb).value}",
                wire.DENIED,
            )
        if self._sealer is None and self._has_keys:
            self._sealer = await self._challenge()
        return None if self._sealer is None else self._sealer.seal(key, payload)

    async def _challenge(self) -> Sealer | None:
        from seoro.keys.errors import InvalidKeys  # noqa: PLC0415 - only where there are keys
        from seoro.keys.sealing import NONCE, Sealer  # noqa: PLC0415 - the same

        nonce, sealer = secrets.token_bytes(NONCE), Sealer(self._keys, self._executor)
        key = executor_command(NAMESPACE, self._executor, wire.CHALLENGE.name)
        asked = time.time_ns()
        try:
            said = await self._session.query(key, encode(wire.Challenge(nonce=nonce)), TIMEOUT)
            proof = decode(wire.Proof, said)
            sealer.accept(
                proof.certificate, proof.signature, nonce, proof.boot, proof.now, (asked, time.time_ns())
            )
        except Refused as refused:
            reason = said_in(refused.payload)
            if reason.code == Result.FEATURE_UNSUPPORTED and not self._is_required:
                self._has_keys = False
                return None
            raise BackendRefused(reason.message, reason.code) from None
        except (WireError, InvalidKeys) as error:
            raise BackendRefused(
                f"the executor '{self._executor}' is not to be trusted: {error}", wire.DENIED
            ) from None
        return sealer
