"""Signed statements of executors and nodes, with the certificate of the sender.

A signature covers the statement together with the request, so that a recorded statement answers no other request.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from functools import lru_cache
from typing import Any, Final

import msgpack
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.security.keys.certificates import Identity, check_issued, check_time, identity_of
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.keys.revocation import Revocations
from seoro.security.keys.roles import Role

LARGEST: Final = 8192  # [bytes] of a signature with its certificate
ALGORITHM: Final = ec.ECDSA(hashes.SHA256())


INVALID_SIGNATURE: Final = "invalid signature: the message was changed, or signed by another sender"


def digest(*parts: Any) -> bytes:
    """Pack the parts of a statement into the bytes to sign."""
    packed: bytes = msgpack.packb(parts)
    return packed


def certificate_der(certificate: x509.Certificate) -> bytes:
    """Encode a certificate as DER."""
    return certificate.public_bytes(serialization.Encoding.DER)


def check_signature(certificate: x509.Certificate, signature: bytes, signed: bytes) -> None:
    """Check that the owner of a certificate has signed some bytes.

    Raises:
        InvalidKeys: The signature is invalid.
    """
    public = certificate.public_key()
    try:
        if not isinstance(public, ec.EllipticCurvePublicKey):
            raise InvalidSignature
        public.verify(signature, signed, ALGORITHM)
    except InvalidSignature:
        raise InvalidKeys(INVALID_SIGNATURE) from None


def sign(keys: Keys, *statement: Any) -> bytes:
    """Sign a statement; returns the signature with the certificate of the signer.

    Args:
        keys: Keys of the signer.
        statement: Parts of the statement, packable by msgpack.
    """
    signature = keys.key.sign(digest(*statement), ALGORITHM)
    signed: bytes = msgpack.packb([certificate_der(keys.certificate), signature])
    return signed


class StatementVerifier:
    """Verifies statements of executors and nodes of a lab.

    Args:
        authority: Certificate of the lab.
        revoked: Returns the current list of revoked keys.
    """

    def __init__(
        self, authority: x509.Certificate, revoked: Callable[[], Revocations] = lambda: Revocations(0)
    ) -> None:
        self._authority = authority
        self._revoked = revoked

    def check(self, signed: bytes, role: Role, name: str, *statement: Any) -> None:
        """Check that a statement was signed by the executor or node of a name.

        Args:
            signed: Result of `sign`.
            role: Expected role of the signer.
            name: Expected name of the signer.
            statement: Parts of the statement.

        Raises:
            InvalidKeys: Another signer, a changed statement, or a key that is expired or revoked.
        """
        certificate, signature = _parts(signed)
        found, identity = load_certificate(certificate, self._authority, "its signature")
        if identity.role is not role or identity.name != name:
            raise InvalidKeys(f"signed with the keys of {identity}; expected: {name} ({role.value})")
        check_time(identity, datetime.now(UTC))
        if self._revoked().contains(identity.serial):
            raise InvalidKeys(f"{identity} is revoked")
        check_signature(found, signature, digest(*statement))


@lru_cache(1000)  # of the last senders
def load_certificate(data: bytes, authority: x509.Certificate, where: str) -> tuple[x509.Certificate, Identity]:
    """Decode a certificate that was issued by the authority of a lab; returns it with its identity.

    Args:
        data: The certificate, as DER.
        authority: Certificate of the lab.
        where: Origin of the certificate, for messages.

    Raises:
        InvalidKeys: The certificate is invalid, or was not issued by the lab.
    """
    try:
        certificate = x509.load_der_x509_certificate(data)
    except ValueError as error:
        raise InvalidKeys(f"invalid certificate in {where}") from error
    check_issued(certificate, authority)
    return certificate, identity_of(certificate)


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
