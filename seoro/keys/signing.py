"""Signed statements of executors and nodes, with the certificate of the sender.

A statement is signed together with what it answers, so that one that was recorded answers nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
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

LARGEST: Final = 8192  # [bytes] of a signature with its certificate
ALGORITHM: Final = ec.ECDSA(hashes.SHA256())
_MOST_KNOWN: Final = 100  # certificates that are remembered as checked


def digest(*parts: Any) -> bytes:
    """The bytes that are signed for some parts."""
    packed: bytes = msgpack.packb(parts)
    return packed


def certificate_der(certificate: x509.Certificate) -> bytes:
    """A certificate as bytes."""
    return certificate.public_bytes(serialization.Encoding.DER)


def check_signature(certificate: x509.Certificate, signature: bytes, signed: bytes) -> None:
    """Check that the owner of a certificate has signed something.

    Raises:
        InvalidKeys: The owner has not.
    """
    public = certificate.public_key()
    try:
        if not isinstance(public, ec.EllipticCurvePublicKey):
            raise InvalidSignature
        public.verify(signature, signed, ALGORITHM)
    except InvalidSignature:
        raise InvalidKeys(
            "the signature is wrong: it was changed on its way, or is not by whom it names"
        ) from None


def sign(keys: Keys, *said: Any) -> bytes:
    """Sign a statement; returns the signature with the certificate of the signer.

    Args:
        keys: Of the signer.
        said: Its parts, as msgpack has them.
    """
    signature = keys.key.sign(digest(*said), ALGORITHM)
    signed: bytes = msgpack.packb([certificate_der(keys.certificate), signature])
    return signed


class Signatures:
    """Checks statements of executors and nodes of a lab.

    Args:
        authority: Certificate of the lab.
        revoked: Returns who is revoked.
    """

    def __init__(
        self, authority: x509.Certificate, revoked: Callable[[], Revocations] = lambda: Revocations(0)
    ) -> None:
        self._authority = authority
        self._revoked = revoked
        self._known: dict[bytes, tuple[x509.Certificate, Identity]] = {}

    def check(self, signed: bytes, role: Role, name: str, *said: Any) -> None:
        """Check that a statement is by the executor or the node of a name.

        Args:
            signed: The result of `sign`.
            role: Of the signer.
            name: Of the signer.
            said: The parts of the statement.

        Raises:
            InvalidKeys: The statement is by another, was changed, or the key of its signer is not valid any more.
        """
        certificate, signature = _parts(signed)
        found, identity = self._certificate(certificate)
        if identity.role is not role or identity.name != name:
            raise InvalidKeys(f"it is signed with the keys of {identity}, not of {name} ({role.value})")
        check_time(identity, datetime.now(UTC))
        if self._revoked().has(identity.serial):
            raise InvalidKeys(f"{identity} is revoked")
        check_signature(found, signature, digest(*said))

    def _certificate(self, data: bytes) -> tuple[x509.Certificate, Identity]:
        known = self._known.get(data)
        if known is None:
            try:
                found = x509.load_der_x509_certificate(data)
            except ValueError as error:
                raise InvalidKeys("its signature has an unreadable certificate") from error
            check_issued(found, self._authority)
            known = found, identity_of(found)
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[data] = known
        return known


def _parts(signed: bytes) -> tuple[bytes, bytes]:
    if not signed:
        raise InvalidKeys("it is not signed")
    try:
        if len(signed) > LARGEST:
            raise ValueError("too large")
        certificate, signature = msgpack.unpackb(signed)
        if type(certificate) is not bytes or type(signature) is not bytes:
            raise TypeError("two byte strings were expected")
    except (ValueError, TypeError, msgpack.UnpackException) as error:
        raise InvalidKeys(f"its signature is invalid: {error}") from error
    return certificate, signature
