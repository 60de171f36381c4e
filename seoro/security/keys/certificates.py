"""Certificates: X.509 with keys on the curve P-256.

A certificate names its owner by a URI among its alternative names, `seoro://LAB/ROLE/NAME`. Its common name is a
*slot* instead, such as `operator-3`. Routers identify sessions by common names, from a list that they read at
their start. Slots are numbered for each role, so that list is known in advance, and routers need no update for a
new identity. A slot is never reused.

Serial numbers begin with role and slot, so that a list of revoked serial numbers names the revoked slots.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import lru_cache
from typing import Final

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.roles import Role

SLOTS: Final = 250  # for each role
SCHEME: Final = "seoro"
_URI: Final = re.compile(r"seoro://(?P<lab>[a-z0-9_-]{1,64})/(?P<role>[a-z]+)/(?P<name>[a-z0-9_-]{1,64})")
_NAME: Final = re.compile(r"[a-z0-9_-]{1,64}")
_SLOT_BITS: Final = 16
_RANDOM_BITS: Final = 96
_EARLY: Final = timedelta(hours=2)  # tolerance for clocks of the lab that are behind that of the authority
_LOCAL: Final = ("localhost", "127.0.0.1", "::1")

PrivateKey = ec.EllipticCurvePrivateKey


@dataclass(frozen=True)
class CertificateSlot:
    """Numbered common name of a role, by which routers identify sessions."""

    role: Role
    number: int

    def __str__(self) -> str:
        return f"{self.role.value}-{self.number}"


@dataclass(frozen=True)
class Identity:
    """Contents of a certificate: lab, name, role, serial number, validity and hosts."""

    lab: str
    name: str
    role: Role
    serial: int
    begins: datetime
    ends: datetime
    hosts: tuple[str, ...] = ()

    @property
    def slot(self) -> CertificateSlot:
        """Slot in the serial number."""
        return slot_of(self.serial)

    def __str__(self) -> str:
        return f"{self.name} ({self.role.value})"


@lru_cache(1024)  # called for each verified answer
def slot_of(serial: int) -> CertificateSlot:
    """Return the slot that a serial number begins with.

    Raises:
        InvalidKeys: The serial number is not one of `seoro keys`.
    """
    place = serial >> _RANDOM_BITS
    number, role = place & ((1 << _SLOT_BITS) - 1), (place >> _SLOT_BITS) - 1
    if not 0 <= role < len(Role) or not 1 <= number <= SLOTS:
        raise InvalidKeys("invalid serial number of a certificate: it was not created by `seoro keys`")
    return CertificateSlot(list(Role)[role], number)


def _serial(slot: CertificateSlot) -> int:
    place = (slot.role.number + 1) << _SLOT_BITS | slot.number
    return place << _RANDOM_BITS | secrets.randbits(_RANDOM_BITS)


def check_name(name: str, what: str) -> None:
    """Check that a name is valid in Zenoh keys and file names.

    Raises:
        InvalidKeys: It is invalid.
    """
    if _NAME.fullmatch(name) is None:
        raise InvalidKeys(
            f"invalid name '{name}' of {what}", help="use up to 64 lower-case letters, digits, '_' and '-'"
        )


def new_key() -> PrivateKey:
    """Generate a private key."""
    return ec.generate_private_key(ec.SECP256R1())


def key_pem(key: PrivateKey) -> bytes:
    """Encode a private key as PEM."""
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )


def certificate_pem(certificate: x509.Certificate) -> bytes:
    """Encode a certificate as PEM."""
    return certificate.public_bytes(serialization.Encoding.PEM)


def make_authority(lab: str, days: float) -> tuple[PrivateKey, x509.Certificate]:
    """Create the private key and the certificate of a lab.

    Args:
        lab: Name of the lab.
        days: Validity of the certificate [days].
    """
    key = new_key()
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"seoro lab {lab}")])
    builder = (
        _builder(name, name, key, days)
        .serial_number(x509.random_serial_number())
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(_usage(signs_certificates=True), critical=True)
        .add_extension(
            x509.SubjectAlternativeName([x509.UniformResourceIdentifier(f"{SCHEME}://{lab}")]), critical=False
        )
    )
    return key, builder.sign(key, hashes.SHA256())


def issue(
    authority: tuple[PrivateKey, x509.Certificate],
    key: ec.EllipticCurvePublicKey,
    name: str,
    slot: CertificateSlot,
    days: float,
    hosts: Sequence[str] = (),
) -> x509.Certificate:
    """Issue a certificate.

    Args:
        authority: Private key and certificate of the lab.
        key: Public key of the owner.
        name: Name of the owner.
        slot: Slot of the owner, never used by another.
        days: Validity [days]; ends with that of the lab at the latest.
        hosts: Further host names and addresses of an owner that listens.
    """
    signing, certificate = authority
    lab = lab_of(certificate)
    subject = x509.Name(
        [
            x509.NameAttribute(NameOID.COMMON_NAME, str(slot)),
            x509.NameAttribute(NameOID.ORGANIZATIONAL_UNIT_NAME, name),
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, lab),
        ]
    )
    names: list[x509.GeneralName] = [x509.UniformResourceIdentifier(f"{SCHEME}://{lab}/{slot.role.value}/{name}")]
    uses = [] if slot.role is Role.SITE else [ExtendedKeyUsageOID.CLIENT_AUTH]
    if slot.role.listens:
        uses.append(ExtendedKeyUsageOID.SERVER_AUTH)
        names += [_general_name(host) for host in dict.fromkeys((*_LOCAL, *hosts))]
    builder = (
        _builder(subject, certificate.subject, key, days, certificate.not_valid_after_utc)
        .serial_number(_serial(slot))
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_usage(signs_certificates=False), critical=True)
        .add_extension(x509.ExtendedKeyUsage(uses), critical=False)
        .add_extension(x509.SubjectAlternativeName(names), critical=False)
    )
    return builder.sign(signing, hashes.SHA256())


def _builder(
    subject: x509.Name,
    issuer: x509.Name,
    key: PrivateKey | ec.EllipticCurvePublicKey,
    days: float,
    latest: datetime | None = None,
) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    ends = now + timedelta(days=days)
    public = key.public_key() if isinstance(key, PrivateKey) else key
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(public)
        .not_valid_before(now - _EARLY)
        .not_valid_after(ends if latest is None else min(ends, latest))
    )


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=True,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        if re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?", host) is None:
            raise InvalidKeys(
                f"invalid host '{host}'; expected a host name or an address",
                help="such as lab-a.example.org or 192.168.0.5",
            ) from None
        return x509.DNSName(host)


def lab_of(certificate: x509.Certificate) -> str:
    """Return the name of the lab in the certificate of an authority.

    Raises:
        InvalidKeys: The certificate was not created by `seoro keys init`.
    """
    for uri in _uris(certificate):
        scheme, _, lab = uri.partition("://")
        if scheme == SCHEME and _NAME.fullmatch(lab):
            return lab
    raise InvalidKeys("the certificate of the lab was not made by `seoro keys init`")


def identity_of(certificate: x509.Certificate) -> Identity:
    """Return the identity in a certificate.

    Raises:
        InvalidKeys: The certificate was not created by `seoro keys`, or contradicts itself.
    """
    for uri in _uris(certificate):
        match = _URI.fullmatch(uri)
        if match is None or match["role"] not in {role.value for role in Role}:
            continue
        identity = Identity(
            match["lab"],
            match["name"],
            Role(match["role"]),
            certificate.serial_number,
            certificate.not_valid_before_utc,
            certificate.not_valid_after_utc,
            _hosts(certificate),
        )
        commons = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
        if [common.value for common in commons] == [str(identity.slot)] and identity.slot.role is identity.role:
            return identity
    raise InvalidKeys("a certificate was not made by `seoro keys add`")


def _uris(certificate: x509.Certificate) -> list[str]:
    names = _alternative_names(certificate)
    return [] if names is None else names.get_values_for_type(x509.UniformResourceIdentifier)


def _hosts(certificate: x509.Certificate) -> tuple[str, ...]:
    names = _alternative_names(certificate)
    if names is None:
        return ()
    addresses = [str(address) for address in names.get_values_for_type(x509.IPAddress)]
    return (*names.get_values_for_type(x509.DNSName), *addresses)


def _alternative_names(certificate: x509.Certificate) -> x509.SubjectAlternativeName | None:
    try:
        return certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, ValueError):
        return None


def check_issued(certificate: x509.Certificate, authority: x509.Certificate) -> None:
    """Check that a certificate was signed by the authority of a lab.

    Raises:
        InvalidKeys: The signature is invalid.
    """
    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        raise InvalidKeys(f"the certificate was not signed by the lab '{lab_of(authority)}'") from None


def check_time(identity: Identity, now: datetime) -> None:
    """Check that a certificate is valid at a time.

    Raises:
        InvalidKeys: The certificate is not valid yet, or has expired.
    """
    if now < identity.begins:
        raise InvalidKeys(
            f"the certificate of {identity} is not valid before {_shown(identity.begins)}",
            help="check the clocks of this machine and of the machine that created the keys",
        )
    if now > identity.ends:
        raise InvalidKeys(
            f"the certificate of {identity} expired on {_shown(identity.ends)}",
            help=f"run `seoro keys renew {identity.name}` where the lab key is",
        )


def _shown(time: datetime) -> str:
    return time.strftime("%Y-%m-%d %H:%M UTC")
