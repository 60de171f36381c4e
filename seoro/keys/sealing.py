"""Sealed commands: who says something can be told, whatever has carried it.

A seal travels beside a command. It has the certificate of the sender and a signature over the key on which the
command is said (which names the executor and the verb), over what is said, over which start of the executor it is
for, a time, and a number that is used once. So a command cannot be changed, given to another executor, or said
again: neither later, nor to the same executor after it has been started anew.

Before its first command a client challenges the executor, which proves by a signature that it is the one of
that name, and says which start of it this is, and what time it is by its clock. Clients seal with times of that
clock, so that clocks of machines may differ.
"""

from __future__ import annotations

import hashlib
import secrets
import time
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import islice
from typing import Any, Final

import msgpack
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.keys.certificates import Identity, check_issued, check_time, identity_of
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.revocation import Revocations
from seoro.keys.roles import Role

WINDOW: Final = 30.0  # [s] by which the time of a seal may differ from that of the executor
LARGEST: Final = 8192  # [bytes] of a seal
NONCE: Final = 16  # [bytes]
_ALGORITHM: Final = ec.ECDSA(hashes.SHA256())
_COMMAND: Final = "seoro command 1"
_PROOF: Final = "seoro executor 1"
_MOST_KNOWN: Final = 1000  # certificates that are remembered as checked


class Stale(InvalidKeys):
    """A seal that was right before, or will be: it is for another start of the executor, or of another time."""


def _digest(*parts: Any) -> bytes:
    packed: bytes = msgpack.packb(parts)
    return packed


def certificate_der(certificate: x509.Certificate) -> bytes:
    """A certificate as bytes."""
    return certificate.public_bytes(serialization.Encoding.DER)


def prove(keys: Keys, executor: str, nonce: bytes, boot: str, now: int) -> bytes:
    """The signature by which an executor answers a challenge.

    Args:
        keys: Of the executor.
        executor: Its name.
        nonce: What the challenger has drawn.
        boot: Which start of the executor this is.
        now: [ns] since 1970, by its clock.
    """
    return keys.key.sign(_digest(_PROOF, executor, nonce, boot, now), _ALGORITHM)


class Sealer:
    """Seals the commands of a client to one executor.

    Args:
        keys: Of the client.
        executor: Name of the executor.
    """

    def __init__(self, keys: Keys, executor: str) -> None:
        self._keys = keys
        self._executor = executor
        self._certificate = certificate_der(keys.certificate)
        self._boot = ""  # not known before `accept`
        self._offset = 0  # [ns] of the executor's clock from ours

    @property
    def identity(self) -> Identity:
        """Who seals."""
        return self._keys.identity

    def accept(
        self, certificate: bytes, signature: bytes, nonce: bytes, boot: str, now: int, asked: tuple[int, int]
    ) -> None:
        """Take the answer of the executor to a challenge.

        Args:
            certificate: Of the executor.
            signature: Of `prove`.
            nonce: What the challenge had.
            boot: Which start of the executor this is.
            now: [ns] since 1970, by its clock.
            asked: When it was asked and when the answer was there; [ns] since 1970, by ours.

        Raises:
            InvalidKeys: It is not the executor of that name.
        """
        found, identity = _load(certificate, self._keys.authority)
        if identity.role is not Role.EXECUTOR or identity.name != self._executor:
            raise InvalidKeys(f"who answers for the executor '{self._executor}' has the keys of {identity}")
        check_time(identity, datetime.now(UTC))
        _check_signature(found, signature, _digest(_PROOF, self._executor, nonce, boot, now))
        self._boot, self._offset = boot, now - sum(asked) // 2

    def seal(self, key: str, payload: bytes) -> bytes:
        """The seal of a command that is said on a key."""
        now, nonce = time.time_ns() + self._offset, secrets.token_bytes(NONCE)
        signed = _digest(_COMMAND, key, self._boot, now, nonce, hashlib.sha256(payload).digest())
        signature = self._keys.key.sign(signed, _ALGORITHM)
        seal: bytes = msgpack.packb([self._certificate, self._boot, now, nonce, signature])
        return seal


class Verifier:
    """Finds out who has sealed commands.

    Args:
        keys: Of the executor.
        boot: Which start of it this is.
        revoked: Who is revoked, at any time.
        clock: [ns] since 1970.
    """

    def __init__(
        self, keys: Keys, boot: str, revoked: Callable[[], Revocations], clock: Callable[[], int] = time.time_ns
    ) -> None:
        self._keys = keys
        self._boot = boot
        self._revoked = revoked
        self._clock = clock
        self._known: dict[bytes, tuple[x509.Certificate, Identity]] = {}
        self._nonces: dict[bytes, int] = {}  # with their times, in the order in which they came

    def verify(self, key: str, payload: bytes, seal: bytes) -> Identity:
        """Who has sealed a command.

        Raises:
            Stale: The client has to challenge this executor, and seal it again.
            InvalidKeys: Nobody who may, or it was said before.
        """
        certificate, boot, stamp, nonce, signature = _parts(seal)
        found, identity = self._certificate(certificate)
        now = self._clock()
        check_time(identity, datetime.fromtimestamp(now / 1e9, UTC))
        if self._revoked().has(identity.serial):
            raise InvalidKeys(f"{identity} is revoked")
        signed = _digest(_COMMAND, key, boot, stamp, nonce, hashlib.sha256(payload).digest())
        _check_signature(found, signature, signed)
        if boot != self._boot:
            raise Stale("the command is for another start of this executor")
        if abs(now - stamp) > WINDOW * 1e9:
            raise Stale(f"the time of the command is {abs(now - stamp) / 1e9:.0f} s from that of this executor")
        self._use(nonce, stamp, now)
        return identity

    def _use(self, nonce: bytes, stamp: int, now: int) -> None:
        if nonce in self._nonces:
            raise InvalidKeys("the command was said before")
        oldest = list(islice(self._nonces.items(), 2))  # as two go for each that comes, they do not pile up
        for old, came in oldest:
            if now - came > 2.0 * WINDOW * 1e9:
                del self._nonces[old]
        self._nonces[nonce] = max(now, stamp)

    def _certificate(self, data: bytes) -> tuple[x509.Certificate, Identity]:
        known = self._known.get(data)
        if known is None:
            known = _load(data, self._keys.authority)
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[data] = known
        return known


def _parts(seal: bytes) -> tuple[bytes, str, int, bytes, bytes]:
    if not seal:
        raise InvalidKeys(
            "this executor takes commands with keys only", help="`--keys DIR` or SEORO_KEYS names them"
        )
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


def _check_signature(certificate: x509.Certificate, signature: bytes, signed: bytes) -> None:
    public = certificate.public_key()
    try:
        if not isinstance(public, ec.EllipticCurvePublicKey):
            raise InvalidSignature
        public.verify(signature, signed, _ALGORITHM)
    except InvalidSignature:
        raise InvalidKeys(
            "the signature is wrong: it was changed on its way, or is not by whom it names"
        ) from None
