"""Who is revoked: a list that the authority signs and others read (a certificate revocation list of X.509)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.keys.certificates import PrivateKey, Seat, lab_of, seat_of
from seoro.keys.errors import InvalidKeys
from seoro.keys.files import read_file


@dataclass(frozen=True)
class Revocations:
    """A list of serial numbers, with when each was revoked.

    Attributes:
        number: Which list this is; later ones have higher numbers.
    """

    number: int
    revoked: Mapping[int, datetime] = field(default_factory=dict)

    def has(self, serial: int) -> bool:
        """Whether a certificate is revoked, or another that has had its seat."""
        return seat_of(serial) in self.seats

    @property
    def seats(self) -> frozenset[Seat]:
        """The seats of those who are revoked."""
        return frozenset(map(seat_of, self.revoked))

    def also(self, serials: Iterable[int], when: datetime) -> Revocations:
        """The next list, with some more."""
        return Revocations(self.number + 1, {**dict.fromkeys(serials, when), **self.revoked})


def make_list(revocations: Revocations, key: PrivateKey, authority: x509.Certificate) -> bytes:
    """A list as text, signed."""
    now = datetime.now(UTC)
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(authority.subject)
        .last_update(now)
        .next_update(now + timedelta(days=3650))
        .add_extension(x509.CRLNumber(revocations.number), critical=False)
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
    return Revocations(number, {entry.serial_number: entry.revocation_date_utc for entry in found})


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
