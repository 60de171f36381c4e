"""Commands to executors and nodes with seals, where there are keys."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from seoro.bridges.session import AsyncSession, Refused
from seoro.bridges.wire.keys import NAMESPACE, executor_command, node_command
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.message import WireError, encode
from seoro.bridges.wire.proving import CHALLENGE, DENIED, Challenge, is_open
from seoro.bridges.wire.refusal import said_in
from seoro.bridges.wire.results import Result
from seoro.errors import BackendRefused
from seoro.keys.roles import MOVING, Role, executor_verbs, least_role

if TYPE_CHECKING:
    from seoro.keys.folder import Keys
    from seoro.keys.sealing import Sealer

TIMEOUT: Final = 5.0  # [s]


@dataclass(frozen=True)
class Peer:
    """Who is asked: an executor or a node, by its name."""

    name: str
    role: Role

    def key(self, verb: str) -> str:
        """On which it is asked for a verb."""
        command = node_command if self.role is Role.NODE else executor_command
        return command(NAMESPACE, self.name, verb)

    def lets(self, role: Role, verb: str) -> bool:
        """Whether those of a role may ask it for a verb."""
        if self.role is Role.NODE:
            return role in MOVING or is_open(verb)
        return verb in executor_verbs(role)

    def least(self, verb: str) -> Role:
        """The least role that may."""
        return Role.OPERATOR if self.role is Role.NODE else least_role(verb)


class Seals:
    """Seals what is said to an executor or a node.

    Args:
        session: That reaches it.
        peer: Who it is.
        keys: Of who asks.
        is_required: Whether one without keys is not to be trusted; if it is, commands go to it without seals.
    """

    def __init__(self, session: AsyncSession, peer: Peer, keys: Keys, is_required: bool) -> None:
        self._session = session
        self._peer = peer
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
            BackendRefused: It is not.
            SessionError: It does not answer.
        """
        if self._sealer is None and self._has_keys:
            self._sealer = await self._challenge()

    async def seal(self, verb: str, key: str, payload: bytes) -> bytes | None:
        """The seal of a command; None if whom it is for has no keys, and need not have any.

        An emergency stop to a node is sealed before that has proven anything: it must not wait.

        Raises:
            BackendRefused: These keys may not say that, or it is not who it says.
            SessionError: It does not answer.
        """
        self.check(verb)
        if verb == EMERGENCY_STOP.name and self._peer.role is Role.NODE:
            from seoro.keys.sealing import seal_urgently  # noqa: PLC0415 - only where there are keys

            return seal_urgently(self._keys, key, payload)
        await self.prove()
        return None if self._sealer is None else self._sealer.seal(key, payload)

    def check(self, verb: str) -> None:
        """Refuse what these keys may not say.

        Raises:
            BackendRefused: They may not.
        """
        identity = self._keys.identity
        if not self._peer.lets(identity.role, verb):
            least = self._peer.least(verb).value
            raise BackendRefused(
                f"the keys here are those of {identity}: `{verb}` is for one who is {least}", DENIED
            )

    async def _challenge(self) -> Sealer | None:
        from seoro.keys.errors import InvalidKeys  # noqa: PLC0415 - only where there are keys
        from seoro.keys.sealing import NONCE, Sealer  # noqa: PLC0415 - the same

        nonce, sealer = secrets.token_bytes(NONCE), Sealer(self._keys, self._peer.name, self._peer.role)
        asked, called = time.time_ns(), f"the {self._peer.role.value} '{self._peer.name}'"
        try:
            said = await self._session.query(
                self._peer.key(CHALLENGE.name), encode(Challenge(nonce=nonce)), TIMEOUT
            )
            proof = CHALLENGE.read_answer(said)
            sealer.accept(
                proof.certificate, proof.signature, nonce, proof.boot, proof.now, (asked, time.time_ns())
            )
        except Refused as refused:
            reason = said_in(refused.payload)
            if reason.code == Result.FEATURE_UNSUPPORTED:
                if not self._is_required:
                    self._has_keys = False
                    return None
                raise BackendRefused(
                    f"{called} is not to be trusted: it does not prove who it is; start it with keys", DENIED
                ) from None
            raise BackendRefused(reason.message, reason.code) from None
        except (WireError, InvalidKeys) as error:
            raise BackendRefused(f"{called} is not to be trusted: {error}", DENIED) from None
        return sealer


def node_seals(session: AsyncSession, name: str, keys: Keys | None) -> Seals | None:
    """What seals commands to a node; None where there are no keys."""
    return None if keys is None else Seals(session, Peer(name, Role.NODE), keys, is_required=True)
