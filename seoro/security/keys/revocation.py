"""List of revoked certificates, signed by the authority (a certificate revocation list of X.509).

An extension of the list maps the slots of executors and nodes to their names. Routers identify sessions by slots,
and reserve each name for its slot.
"""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cached_property
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.security.keys.certificates import CertificateSlot, Identity, PrivateKey, lab_of, slot_of
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.files import read_file
from seoro.security.keys.folder import Keys
from seoro.security.keys.roles import Role

_NAMES: Final = x509.ObjectIdentifier("2.25.199700432544193162380911776863607034762")
_OCTETS: Final = 4  # the tag of an OCTET STRING
PERIOD: Final = 0.5  # [s] between two looks at the file

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Revocations:
    """Serial numbers of revoked certificates, with the times of their revocation.

    Attributes:
        number: Number of the list; later lists have higher numbers.
        names: Names of executors and nodes that were known when the list was made.
    """

    number: int
    revoked: Mapping[int, datetime] = field(default_factory=dict)
    names: Mapping[CertificateSlot, str] = field(default_factory=dict)

    def contains(self, serial: int) -> bool:
        """Whether the slot of a certificate is revoked."""
        return slot_of(serial) in self.slots

    @cached_property
    def slots(self) -> frozenset[CertificateSlot]:
        """Revoked slots."""
        return frozenset(map(slot_of, self.revoked))

    def also(self, serials: Iterable[int], when: datetime) -> Revocations:
        """Return the next list, with further serial numbers."""
        revoked = {**dict.fromkeys(serials, when), **self.revoked}
        gone = set(map(slot_of, revoked))
        return Revocations(
            self.number + 1, revoked, {slot: name for slot, name in self.names.items() if slot not in gone}
        )

    def named(self, slot: CertificateSlot, name: str) -> Revocations:
        """Return the next list, with the name of one more slot."""
        return Revocations(self.number + 1, self.revoked, {**self.names, slot: name})

    def has_same_access(self, other: Revocations) -> bool:
        """Whether another list makes no difference to routers."""
        return (self.slots, self.names) == (other.slots, other.names)


def make_list(revocations: Revocations, key: PrivateKey, authority: x509.Certificate) -> bytes:
    """Sign a list, and encode it as PEM."""
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
    """Decode a list.

    Raises:
        InvalidKeys: The list is invalid, or not signed by the authority.
    """
    try:
        found = x509.load_pem_x509_crl(data)
        number = found.extensions.get_extension_for_class(x509.CRLNumber).value.crl_number
    except (ValueError, x509.ExtensionNotFound) as error:
        raise InvalidKeys("invalid list of revoked certificates") from error
    public = authority.public_key()
    if not isinstance(public, ec.EllipticCurvePublicKey) or not found.is_signature_valid(public):
        raise InvalidKeys(f"the list was not signed by the lab '{lab_of(authority)}'")
    revoked = {entry.serial_number: entry.revocation_date_utc for entry in found}
    return Revocations(number, revoked, _names_in(found))


def _packed(names: Mapping[CertificateSlot, str]) -> bytes:
    """Encode names as an OCTET STRING of DER."""
    content = json.dumps({str(slot): name for slot, name in names.items()}).encode()
    size = len(content)
    if size < 0x80:  # lengths of DER are one byte below it
        return bytes([_OCTETS, size]) + content
    length = size.to_bytes((size.bit_length() + 7) // 8, "big")
    return bytes([_OCTETS, 0x80 | len(length)]) + length + content


def _names_in(found: x509.CertificateRevocationList) -> dict[CertificateSlot, str]:
    """Return the names in a list; empty for lists of earlier versions."""
    try:
        value = found.extensions.get_extension_for_oid(_NAMES).value
    except x509.ExtensionNotFound:
        return {}
    assert isinstance(value, x509.UnrecognizedExtension), "the extension is unknown to X.509"
    try:
        names = json.loads(value.value[value.value.index(b"{") :])
        return {_slot(text): str(name) for text, name in names.items()}
    except ValueError as error:
        raise InvalidKeys("invalid names of executors and nodes in the list") from error


def _slot(text: str) -> CertificateSlot:
    role, _, number = text.partition("-")
    return CertificateSlot(Role(role), int(number))


def read_list(path: Path, authority: x509.Certificate) -> Revocations:
    """Read the list in a file.

    Raises:
        InvalidKeys: The list is missing or invalid, so that revoked keys would be unknown.
    """
    try:
        return parse_list(read_file(path), authority)
    except InvalidKeys as error:
        raise InvalidKeys(
            f"cannot read the list of revoked keys {path}: {error}",
            help="copy `revoked.crl` from the folder of the lab key",
        ) from error


class RevokedFile:
    """The list of revoked certificates in a folder of keys; read again when it changes.

    Args:
        keys: The keys in this folder.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._list = keys.revoked
        self._stamp: tuple[int, int, int] | None = None
        self._next = float("-inf")  # [s] of the monotonic clock, when to look again

    def current(self) -> Revocations:
        """Return the list; an empty one if the folder has none.

        A file that becomes invalid, older or missing later changes nothing.

        Raises:
            InvalidKeys: The file is invalid, and no valid one was read before.
        """
        now = time.monotonic()
        if self._keys.revoked is None and now >= self._next:
            self._read()
            self._next = now + PERIOD
        return self._list or Revocations(0)

    def check(self, identity: Identity) -> None:
        """Check that an identity is not revoked.

        Raises:
            InvalidKeys: The identity is revoked, or the list is invalid.
        """
        if self.current().contains(identity.serial):
            raise InvalidKeys(f"{identity} is revoked", help=f"listed in `{self._keys.folder.revoked}`")

    def _read(self) -> None:
        stamp = self._keys.folder.revoked_stamp()
        if stamp is None or stamp == self._stamp:
            return
        try:
            found = read_list(self._keys.folder.revoked, self._keys.authority)
            if self._list is not None and found.number < self._list.number:
                raise InvalidKeys(
                    f"outdated list of revoked keys: number {found.number}, expected {self._list.number} or higher"
                )
        except InvalidKeys as error:
            if self._list is None:
                raise
            log.error("%s; using the previous list", error)
        else:
            self._list = found
        self._stamp = stamp
