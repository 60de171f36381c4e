"""Sealed commands: who says something can be told, whatever has carried it.

A seal travels beside a command. It has the certificate of the sender and a signature over the key on which the
command is said (which names the executor and the verb), over what is said, over which start of the executor it is
for, a time, and a number that is used once. So a command cannot be changed, given to another executor, or said
again: neither later, nor to the same executor after it has been started anew.

Before its first command a client challenges the executor, which proves by a signature that it is the one of
that name, and says which start of it this is, and what time it is by its clock. Clients seal with times of that
clock, so that clocks of machines may differ.

Nodes take sealed commands as executors do. An emergency stop is sealed without a challenge, for any start and any
time: no clock, and nobody who is slow to prove who they are, keeps it from being obeyed. Who has recorded one can
say it again once the node has forgotten it, which stops what moves.
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
from cryptography import x509

from seoro.keys.certificates import Identity, check_issued, check_time, identity_of
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.revocation import Revocations
from seoro.keys.revoked_file import RevokedFile
from seoro.keys.roles import Role
from seoro.keys.signing import ALGORITHM, certificate_der, check_signature, digest
from seoro.steady import steady_ns

WINDOW: Final = 30.0  # [s] by which the time of a seal may differ from that of the executor
LARGEST: Final = 8192  # [bytes] of a seal
NONCE: Final = 16  # [bytes]
_COMMAND: Final = "seoro command 1"
_URGENT: Final = "seoro stop 1"
_PROOFS: Final = {Role.EXECUTOR: "seoro executor 2", Role.NODE: "seoro node 2"}
_WINDOW: Final = int(WINDOW * 1e9)  # [ns]
_MOST_KNOWN: Final = 1000  # certificates that are remembered as checked
_MOST_STOPS: Final = 10_000  # emergency stops that are remembered as said


class Stale(InvalidKeys):
    """A seal that was right before, or will be: it is for another start of the executor, or of another time."""


def prove(keys: Keys, name: str, nonce: bytes, boot: str, now: int, exchange: bytes) -> bytes:
    """The signature by which an executor or a node answers a challenge.

    Args:
        keys: Its keys.
        name: Its name.
        nonce: What the challenger has drawn.
        boot: Which start of it this is.
        now: [ns] since 1970, by its clock.
        exchange: Public key for its answers (`seoro.keys.answers`).
    """
    kind = _PROOFS.get(keys.identity.role, "")
    return sign_bytes(keys, digest(kind, name, nonce, boot, now, exchange))


def sign_bytes(keys: Keys, said: bytes) -> bytes:
    """The signature of some bytes."""
    return keys.key.sign(said, ALGORITHM)


def is_command(said: bytes, prefix: str) -> bool:
    """Whether bytes that are to be signed are those of a command on a key that begins so."""
    try:
        kind, key, *_ = msgpack.unpackb(said)
    except (ValueError, msgpack.UnpackException):
        return False
    return kind == _COMMAND and isinstance(key, str) and key.startswith(prefix)


def seal_urgently(keys: Keys, key: str, payload: bytes) -> bytes:
    """The seal of an emergency stop, for any start of whoever it reaches, and any time."""
    return _seal(keys, _URGENT, key, payload, "", time.time_ns())


def _seal(keys: Keys, kind: str, key: str, payload: bytes, boot: str, now: int) -> bytes:
    nonce = secrets.token_bytes(NONCE)
    signature = sign_bytes(keys, _said(kind, key, payload, boot, now, nonce))
    seal: bytes = msgpack.packb([certificate_der(keys.certificate), boot, now, nonce, signature])
    return seal


def _said(kind: str, key: str, payload: bytes, boot: str, stamp: int, nonce: bytes) -> bytes:
    return digest(kind, key, boot, stamp, nonce, hashlib.sha256(payload).digest())


class Sealer:
    """Seals the commands of a client to one executor, or to one node.

    Args:
        keys: Of the client.
        name: Of the executor or the node.
        role: Which of both it is.
    """

    def __init__(self, keys: Keys, name: str, role: Role = Role.EXECUTOR) -> None:
        self._keys = keys
        self._name = name
        self._role = role
        self._boot = ""  # not known before `accept`
        self._offset = 0  # [ns] of the executor's clock from ours

    @property
    def identity(self) -> Identity:
        """Who seals."""
        return self._keys.identity

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
        """Accept the answer to a challenge; return who has proved to be the one of that name.

        Args:
            certificate: Of the executor or node.
            signature: Of `prove`.
            nonce: What the challenge had.
            boot: Which start of it this is.
            now: [ns] since 1970, by its clock.
            asked: When it was asked and when the answer was there; [ns] since 1970, by ours.
            exchange: Public key for its answers.

        Raises:
            InvalidKeys: It is not the one of that name, or is revoked.
        """
        found, identity = _load(certificate, self._keys.authority)
        if identity.role is not self._role or identity.name != self._name:
            raise InvalidKeys(
                f"who answers for the {self._role.value} '{self._name}' has the keys of {identity}",
                help="robots are not given to one who may be another: find out who that is",
            )
        check_time(identity, datetime.now(UTC))
        RevokedFile(self._keys).check(identity)
        if not exchange:
            raise InvalidKeys(f"{self._role.value} '{self._name}' runs a seoro that signs no answers: update it")
        check_signature(found, signature, digest(_PROOFS[self._role], self._name, nonce, boot, now, exchange))
        self._boot, self._offset = boot, now - sum(asked) // 2
        return identity

    def seal(self, key: str, payload: bytes) -> bytes:
        """The seal of a command that is said on a key."""
        return _seal(self._keys, _COMMAND, key, payload, self._boot, time.time_ns() + self._offset)


class Verifier:
    """Finds out who has sealed commands; for any thread.

    Args:
        keys: Of the executor or node.
        boot: Which start of it this is.
        revoked: Who is revoked, at any time.
        clock: [ns] since 1970; the clock by which clients seal, so that of `prove`. If it is set back, nothing is
            accepted that was too old before.
    """

    def __init__(
        self, keys: Keys, boot: str, revoked: Callable[[], Revocations], clock: Callable[[], int] = steady_ns
    ) -> None:
        self._keys = keys
        self._boot = boot
        self._revoked = revoked
        self._clock = clock
        self._known: dict[bytes, tuple[x509.Certificate, Identity]] = {}
        self._nonces: dict[bytes, int] = {}  # with the times of their commands, in the order in which they came
        self._oldest = 0  # [ns] since 1970: commands of before that are refused, and it never gets less
        self._stops: dict[bytes, None] = {}  # the nonces of emergency stops, the same
        self._lock = threading.Lock()

    def verify(self, key: str, payload: bytes, seal: bytes) -> Identity:
        """Who has sealed a command.

        Raises:
            Stale: The client has to challenge this executor, and seal it again.
            InvalidKeys: Nobody who may, or it was said before.
        """
        certificate, boot, stamp, nonce, signature = self._parts(seal)
        with self._lock:
            found, identity = self._certificate(certificate)
            check_time(identity, datetime.now(UTC))
            self._check_revoked(identity)
            check_signature(found, signature, _said(_COMMAND, key, payload, boot, stamp, nonce))
            here = self._keys.identity.role.value
            if boot != self._boot:
                raise Stale(f"the command is for another start of this {here}")
            now = self._clock()
            self._oldest = max(self._oldest, now - _WINDOW)
            if not self._oldest <= stamp <= now + _WINDOW:
                away = f"{abs(now - stamp) / 1e9:.0f} s"
                raise Stale(f"the time of the command is {away} from that of this {here}")
            self._use(nonce, stamp)
        return identity

    def verify_urgent(self, key: str, payload: bytes, seal: bytes) -> Identity:
        """Who has sealed an emergency stop, whatever time it is here, there, and by their certificate.

        Raises:
            InvalidKeys: Nobody, or it was said before.
        """
        certificate, boot, stamp, nonce, signature = self._parts(seal)
        with self._lock:
            found, identity = self._certificate(certificate)
            self._check_revoked(identity)
            check_signature(found, signature, _said(_URGENT, key, payload, boot, stamp, nonce))
            if nonce in self._stops:
                raise InvalidKeys("the stop was said before")
            if len(self._stops) >= _MOST_STOPS:
                del self._stops[next(iter(self._stops))]
            self._stops[nonce] = None
        return identity

    def _check_revoked(self, identity: Identity) -> None:
        if self._revoked().has(identity.serial):
            raise InvalidKeys(f"{identity} is revoked")

    def _parts(self, seal: bytes) -> tuple[bytes, str, int, bytes, bytes]:
        if not seal:
            here = self._keys.identity.role.value
            raise InvalidKeys(
                f"this {here} takes commands with keys only", help="`--keys DIR` or SEORO_KEYS names them"
            )
        return _parts(seal)

    def _use(self, nonce: bytes, stamp: int) -> None:
        """Note a number. It is forgotten only when its command would be refused as too old."""
        if nonce in self._nonces:
            raise InvalidKeys("the command was said before")
        oldest = list(islice(self._nonces.items(), 2))  # as two go for each that comes, they do not pile up
        for old, sealed in oldest:
            if sealed < self._oldest:
                del self._nonces[old]
        self._nonces[nonce] = stamp

    def _certificate(self, data: bytes) -> tuple[x509.Certificate, Identity]:
        known = self._known.get(data)
        if known is None:
            known = _load(data, self._keys.authority)
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[data] = known
        return known


def _parts(seal: bytes) -> tuple[bytes, str, int, bytes, bytes]:
    try:
        if len(seal) > LARGEST:
            raise ValueError("it is too large")
        certificate, boot, stamp, nonce, signature = msgpack.unpackb(seal)
    except (ValueError, TypeError, msgpack.UnpackException) as error:
        raise InvalidKeys(f"what the command is sealed with is no seal: {error}") from error
    kinds = (bytes, str, int, bytes, bytes)
    parts = (certificate, boot, stamp, nonce, signature)
    if not all(type(part) is kind for part, kind in zip(parts, kinds, strict=True)) or len(nonce) != NONCE:
        raise InvalidKeys("what the command is sealed with is no seal")
    return parts


def _load(data: bytes, authority: x509.Certificate) -> tuple[x509.Certificate, Identity]:
    try:
        certificate = x509.load_der_x509_certificate(data)
    except ValueError as error:
        raise InvalidKeys("what the command is sealed with is no seal: its certificate is none") from error
    check_issued(certificate, authority)
    return certificate, identity_of(certificate)
