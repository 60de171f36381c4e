"""Signed commands: the sender is verified on every transport.

The signature travels beside the command, with the certificate of the sender. It covers the key of the request
(with the names of executor and verb), the payload, the start of the executor, a time and a nonce. So a command
cannot be changed, redirected to another executor, or repeated: neither later, nor after a restart of the executor.

Before its first command a client challenges the executor. The executor proves its name by a signature, and reports
the identifier of its start and the time of its clock. Clients sign with times of that clock, so that the clocks of
machines may differ.

Nodes accept signed commands like executors. An emergency stop is signed without a challenge, for any start and any
time, so that neither clocks nor a slow proof delay it. A recorded stop can be repeated after the node has
forgotten it, which only stops robots.
"""

from __future__ import annotations

import hashlib
import secrets
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import islice
from typing import Final

import msgpack

from seoro.concurrency.steady_clock import steady_ns
from seoro.security.keys.certificates import Identity, check_time
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.keys.revocation import Revocations, RevokedFile
from seoro.security.keys.roles import Role
from seoro.security.signing.statements import ALGORITHM, certificate_der, check_signature, digest, load_certificate

WINDOW: Final = 30.0  # [s] by which the time of a signature may differ from that of the executor
LARGEST: Final = 8192  # [bytes] of a signature with its certificate
NONCE: Final = 16  # [bytes]
_COMMAND: Final = "seoro command 1"
_URGENT: Final = "seoro stop 1"
_PROOFS: Final = {Role.EXECUTOR: "seoro executor 2", Role.NODE: "seoro node 2"}
_WINDOW: Final = int(WINDOW * 1e9)  # [ns]
_WHERE: Final = "the signature of the command"
_MOST_STOPS: Final = 10_000  # nonces of emergency stops that are kept


class StaleCommand(InvalidKeys):
    """The signature is for another start of the executor, or its time is outside the window."""


def prove(keys: Keys, name: str, nonce: bytes, boot: str, now: int, exchange: bytes) -> bytes:
    """Return the signature by which an executor or a node answers a challenge.

    Args:
        keys: Keys of the executor or node.
        name: Name of the executor or node.
        nonce: Random bytes of the challenge.
        boot: Identifier of its start.
        now: Time by its clock [ns since 1970].
        exchange: Public key for its answers (`seoro.security.signing.answers`).
    """
    kind = _PROOFS.get(keys.identity.role, "")
    return sign_bytes(keys, digest(kind, name, nonce, boot, now, exchange))


def sign_bytes(keys: Keys, data: bytes) -> bytes:
    """Return the signature of some bytes."""
    return keys.key.sign(data, ALGORITHM)


def is_command(data: bytes, prefix: str) -> bool:
    """Whether bytes to be signed are those of a command whose key begins with `prefix`."""
    try:
        kind, key, *_ = msgpack.unpackb(data)
    except (ValueError, msgpack.UnpackException):
        return False
    return kind == _COMMAND and isinstance(key, str) and key.startswith(prefix)


def sign_emergency_stop(keys: Keys, key: str, payload: bytes) -> bytes:
    """Sign an emergency stop, for any start of the receiver and any time."""
    return _sign(keys, _URGENT, key, payload, "", time.time_ns())


def _sign(keys: Keys, kind: str, key: str, payload: bytes, boot: str, now: int) -> bytes:
    nonce = secrets.token_bytes(NONCE)
    signature = sign_bytes(keys, _signed_bytes(kind, key, payload, boot, now, nonce))
    packed: bytes = msgpack.packb([certificate_der(keys.certificate), boot, now, nonce, signature])
    return packed


def _signed_bytes(kind: str, key: str, payload: bytes, boot: str, stamp: int, nonce: bytes) -> bytes:
    return digest(kind, key, boot, stamp, nonce, hashlib.sha256(payload).digest())


class CommandSigner:
    """Signs the commands of a client to one executor or node.

    Args:
        keys: Keys of the client.
        name: Name of the executor or node.
        role: Role of the executor or node.
    """

    def __init__(self, keys: Keys, name: str, role: Role = Role.EXECUTOR) -> None:
        self._keys = keys
        self._name = name
        self._role = role
        self._boot = ""  # not known before `accept`
        self._offset = 0  # [ns] by which the clock of the executor is ahead

    def accept(
        self,
        certificate: bytes,
        signature: bytes,
        nonce: bytes,
        boot: str,
        now: int,
        asked: tuple[int, int],
        exchange: bytes,
    ) -> Identity:
        """Verify the answer to a challenge; returns the proven identity.

        Args:
            certificate: Certificate of the executor or node.
            signature: Result of `prove`.
            nonce: Random bytes of the challenge.
            boot: Identifier of its start.
            now: Time by its clock [ns since 1970].
            asked: Times of the request and of the answer by the own clock [ns since 1970].
            exchange: Public key for its answers.

        Raises:
            InvalidKeys: The identity has another name or role, or is revoked.
        """
        found, identity = load_certificate(certificate, self._keys.authority, _WHERE)
        if identity.role is not self._role or identity.name != self._name:
            raise InvalidKeys(
                f"it answers with the keys of {identity}, expected: {self._name} ({self._role.value})",
                help="another program may have taken its name: check what runs at its address",
            )
        check_time(identity, datetime.now(UTC))
        RevokedFile(self._keys).check(identity)
        if not exchange:
            raise InvalidKeys("it does not sign answers: update seoro there")
        check_signature(found, signature, digest(_PROOFS[self._role], self._name, nonce, boot, now, exchange))
        self._boot, self._offset = boot, now - sum(asked) // 2
        return identity

    def sign(self, key: str, payload: bytes) -> bytes:
        """Return the signature of a command with the certificate of the client."""
        return _sign(self._keys, _COMMAND, key, payload, self._boot, time.time_ns() + self._offset)


class CommandVerifier:
    """Verifies the signatures of commands; for any thread.

    Args:
        keys: Keys of the executor or node.
        boot: Identifier of its start.
        revoked: Returns the current list of revoked keys.
        clock: Clock of `prove`, by which clients sign [ns since 1970]. If it is set back, commands that were too
            old before stay rejected.
    """

    def __init__(
        self, keys: Keys, boot: str, revoked: Callable[[], Revocations], clock: Callable[[], int] = steady_ns
    ) -> None:
        self._keys = keys
        self._boot = boot
        self._revoked = revoked
        self._clock = clock
        self._nonces: dict[bytes, int] = {}  # with the times of their commands, in order of arrival
        self._oldest = 0  # [ns since 1970] older commands are rejected; never decreases
        self._stops: dict[bytes, None] = {}  # nonces of emergency stops, in order of arrival
        self._lock = threading.Lock()

    def verify(self, key: str, payload: bytes, signed: bytes) -> Identity:
        """Return the sender of a command.

        Raises:
            StaleCommand: The client has to challenge this executor and sign the command again.
            InvalidKeys: The signature is invalid or revoked, or the command was received before.
        """
        certificate, boot, stamp, nonce, signature = self._parts(signed)
        with self._lock:
            found, identity = load_certificate(certificate, self._keys.authority, _WHERE)
            check_time(identity, datetime.now(UTC))
            self._check_revoked(identity)
            check_signature(found, signature, _signed_bytes(_COMMAND, key, payload, boot, stamp, nonce))
            here = self._keys.identity.role.value
            if boot != self._boot:
                raise StaleCommand(f"the command was signed for an earlier start of this {here}")
            now = self._clock()
            self._oldest = max(self._oldest, now - _WINDOW)
            if not self._oldest <= stamp <= now + _WINDOW:
                away = f"{abs(now - stamp) / 1e9:.0f} s"
                raise StaleCommand(f"the time of the command differs by {away} from that of this {here}")
            self._use(nonce, stamp)
        return identity

    def verify_stop(self, key: str, payload: bytes, signed: bytes) -> Identity:
        """Return the sender of an emergency stop, at any time, even if its certificate has expired.

        Raises:
            InvalidKeys: The signature is invalid or revoked, or the stop was received before.
        """
        certificate, boot, stamp, nonce, signature = self._parts(signed)
        with self._lock:
            found, identity = load_certificate(certificate, self._keys.authority, _WHERE)
            self._check_revoked(identity)
            check_signature(found, signature, _signed_bytes(_URGENT, key, payload, boot, stamp, nonce))
            if nonce in self._stops:
                raise InvalidKeys("the stop was received before")
            if len(self._stops) >= _MOST_STOPS:
                del self._stops[next(iter(self._stops))]
            self._stops[nonce] = None
        return identity

    def _check_revoked(self, identity: Identity) -> None:
        if self._revoked().contains(identity.serial):
            raise InvalidKeys(f"{identity} is revoked")

    def _parts(self, signed: bytes) -> tuple[bytes, str, int, bytes, bytes]:
        if not signed:
            here = self._keys.identity.role.value
            raise InvalidKeys(
                f"this {here} accepts signed commands only", help="name the keys with `--keys DIR` or SEORO_KEYS"
            )
        return _parts(signed)

    def _use(self, nonce: bytes, stamp: int) -> None:
        """Record a nonce, until its command is too old to be accepted."""
        if nonce in self._nonces:
            raise InvalidKeys("the command was received before")
        oldest = list(islice(self._nonces.items(), 2))  # two are dropped for each new one, so they do not pile up
        for old, signed_at in oldest:
            if signed_at < self._oldest:
                del self._nonces[old]
        self._nonces[nonce] = stamp


def _parts(signed: bytes) -> tuple[bytes, str, int, bytes, bytes]:
    try:
        if len(signed) > LARGEST:
            raise ValueError("too large")
        certificate, boot, stamp, nonce, signature = msgpack.unpackb(signed)
    except (ValueError, TypeError, msgpack.UnpackException) as error:
        raise InvalidKeys(f"invalid signature of the command: {error or 'unreadable'}") from error
    kinds = (bytes, str, int, bytes, bytes)
    parts = (certificate, boot, stamp, nonce, signature)
    if not all(type(part) is kind for part, kind in zip(parts, kinds, strict=True)) or len(nonce) != NONCE:
        raise InvalidKeys("invalid signature of the command")
    return parts
