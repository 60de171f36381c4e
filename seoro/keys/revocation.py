"""Who is revoked: a list that the authority signs and others read (a certificate revocation list of X.509).

An extension of the list has the names of executors and nodes, by their seats: routers know sessions by seats, and
keep a name from all others.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cached_property
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.keys.certificates import PrivateKey, Seat, lab_of, seat_of
from seoro.keys.errors import InvalidKeys
from seoro.keys.files import read_file
from seoro.keys.roles import Role

_NAMES: Final = x509.ObjectIdentifier("2.25.199700432544193162380911776863607034762")
_OCTETS: Final = 4  # the tag of an OCTET STRING


@dataclass(frozen=True)
class Revocations:
    """A list of serial numbers, with when each was revoked.

    Attributes:
        number: Which list this is; later ones have higher numbers.
        names: Of executors and nodes, as far as they were known when the list was made.
    """

    number: int
    revoked: Mapping[int, datetime] = field(default_factory=dict)
    names: Mapping[Seat, str] = field(default_factory=dict)

    def has(self, serial: int) -> bool:
        """Whether a certificate is revoked, or another that has had its seat."""
        return seat_of(serial) in self.seats

    @cached_property
    def seats(self) -> frozenset[Seat]:
        """The seats of those who are revoked."""
        return frozenset(map(seat_of, self.revoked))

    def also(self, serials: Iterable[int], when: datetime) -> Revocations:
        """The next list, with some more."""
        revoked = {**dict.fromkeys(serials, when), **self.revoked}
        gone = set(map(seat_of, revoked))
        return Revocations(
            self.number + 1, revoked, {seat: name for seat, name in self.names.items() if seat not in gone}
        )

    def named(self, seat: Seat, name: str) -> Revocations:
        """The next list, with the name of one more seat."""
        return Revocations(self.number + 1, self.revoked, {**self.names, seat: name})

    def lets_as(self, other: Revocations) -> bool:
        """Whether routers let the same pass by another list."""
        return (self.seats, self.names) == (other.seats, other.names)


def make_list(revocations: Revocations, key: PrivateKey, authority: x509.Certificate) -> bytes:
    """A list as text, signed."""
    now = datetime.now(UTC)
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(authority.subject)
        .last_update(now)
        .next_update(now + timedelta(days=3650))
        .add_extension(x509.CRLNumber(revocations.number), critical=False)
        .add_extension(x509.UnrecognizedExtension(_NAMES, _packed(revocations.names)), critical=False)
    )
    for serial, when in revocations.revoked.items():
        entry = x509.RevokedCertificateBuilder().serial_number(serial).revocation_date(when)
        builder = builder.add_revoked_certificate(entry.build())
    return builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)


def parse_list(data: bytes, authority: x509.Certificate) -> Revocations:
    """What a list says.

    Raises:
        InvalidKeys: It is none, or the authority has not signed it.
    """
    try:
        found = x509.load_pem_x509_crl(data)
        number = found.extensions.get_extension_for_class(x509.CRLNumber).value.crl_number
    except (ValueError, x509.ExtensionNotFound) as error:
        raise InvalidKeys("it is no list of revoked certificates") from error
    public = authority.public_key()
    if not isinstance(public, ec.EllipticCurvePublicKey) or not found.is_signature_valid(public):
        raise InvalidKeys(f"it was not signed by the lab '{lab_of(authority)}'")
    revoked = {entry.serial_number: entry.revocation_date_utc for entry in found}
    return Revocations(number, revoked, _names_in(found))


def _packed(names: Mapping[Seat, str]) -> bytes:
    """Names as an OCTET STRING of DER."""
    content = json.dumps({str(seat): name for seat, name in names.items()}).encode()
    size = len(content)
    if size < 0x80:  # lengths of DER are one byte below it
        return bytes([_OCTETS, size]) + content
    length = size.to_bytes((size.bit_length() + 7) // 8, "big")
    return bytes([_OCTETS, 0x80 | len(length)]) + length + content


def _names_in(found: x509.CertificateRevocationList) -> dict[Seat, str]:
    """The names in a list; lists of earlier versions have none."""
    try:
        value = found.extensions.get_extension_for_oid(_NAMES).value
    except x509.ExtensionNotFound:
        return {}
    assert isinstance(value, x509.UnrecognizedExtension), "it is an extension of ours"
    try:
        names = json.loads(value.value[value.value.index(b"{") :])
        return {_seat(text): str(name) for text, name in names.items()}
    except ValueError as error:
        raise InvalidKeys("its names of executors and nodes are invalid") from error


def _seat(text: str) -> Seat:
    role, _, number = text.partition("-")
    return Seat(Role(role), int(number))


def read_list(path: Path, authority: x509.Certificate) -> Revocations:
    """The list in a file.

    Raises:
        InvalidKeys: There is none that holds: who is revoked would not be known.
    """
    try:
        return parse_list(read_file(path), authority)
    except InvalidKeys as error:
        raise InvalidKeys(
            f"it is not known who is revoked: {path}: {error}",
            help="`revoked.crl` lies beside the key of the lab, and is copied from there",
        ) from error
