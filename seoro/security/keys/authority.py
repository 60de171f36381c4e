"""Authority of a lab: issues, renews and revokes identities. Files in its folder:

ca.crt  ca.key            its certificate and private key
issued/NAME.SERIAL.crt    every certificate that it has signed
revoked.crl               list of revoked certificates
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from cryptography import x509

from seoro.security.keys.certificates import (
    SLOTS,
    CertificateSlot,
    Identity,
    PrivateKey,
    certificate_pem,
    check_name,
    identity_of,
    issue,
    key_pem,
    lab_of,
    make_authority,
    new_key,
)
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.files import (
    make_folder,
    read_certificate,
    read_file,
    read_pair,
    write_private,
    write_public,
)
from seoro.security.keys.folder import KeyFolder
from seoro.security.keys.revocation import Revocations, make_list, read_list
from seoro.security.keys.roles import NAMED, Role

AUTHORITY_DAYS: Final = 3650.0
IDENTITY_DAYS: Final = 365.0


@dataclass(frozen=True)
class Issued:
    """An issued identity."""

    identity: Identity
    is_revoked: bool


class Authority:
    """Authority with its folder. Created by `init_authority` and `open_authority`."""

    def __init__(self, folder: KeyFolder, key: PrivateKey, certificate: x509.Certificate) -> None:
        self._folder = folder
        self._key = key
        self._certificate = certificate

    @property
    def lab(self) -> str:
        """Name of the lab."""
        return lab_of(self._certificate)

    def issued(self) -> list[Issued]:
        """Return all issued identities, sorted by name and time."""
        revoked = self._revocations()
        identities = [identity_of(read_certificate(path)) for path in self._issued.glob("*.crt")]
        identities.sort(key=lambda identity: (identity.name, identity.begins))
        return [Issued(identity, revoked.contains(identity.serial)) for identity in identities]

    def add(
        self, name: str, role: Role, to: Path, days: float = IDENTITY_DAYS, hosts: Sequence[str] = ()
    ) -> Identity:
        """Issue an identity, in a new folder to hand over to its owner.

        Args:
            name: Name of the identity; unique among identities that are not revoked.
            role: Role of the identity.
            to: The folder; may be that of the authority.
            days: Validity of the certificate [days].
            hosts: Host names and addresses where the identity listens.

        Raises:
            InvalidKeys: The name is taken, the folder contains keys, the lab has no free certificate slot, or the
                role does not listen.
        """
        check_name(name, "an identity")
        _check_hosts(role, hosts)
        issued = self.issued()
        if any(each.identity.name == name and not each.is_revoked for each in issued):
            raise InvalidKeys(
                f"duplicate identity '{name}'", help=f"`seoro keys renew {name}` or `seoro keys revoke {name}`"
            )
        number = 1 + max((each.identity.slot.number for each in issued if each.identity.role is role), default=0)
        if number > SLOTS:
            raise InvalidKeys(
                f"no certificate slot left for role {role.value} in the lab '{self.lab}' (limit: {SLOTS})",
                help="create a new lab by `seoro keys init` in another folder, with new keys for all",
            )
        self._check_free(to)
        return self._issue(name, CertificateSlot(role, number), to, days, hosts)

    def renew(self, name: str, to: Path, days: float = IDENTITY_DAYS, hosts: Sequence[str] = ()) -> Identity:
        """Issue a new key and certificate for an identity; the previous ones stay valid until they expire.

        Raises:
            InvalidKeys: The name is unknown, or its role does not listen.
        """
        identity = self._known(name)[-1]
        _check_hosts(identity.role, hosts)
        return self._issue(name, identity.slot, to, days, hosts or identity.hosts)

    def revoke(self, name: str) -> Revocations:
        """Revoke all certificates of an identity; returns the new list.

        Raises:
            InvalidKeys: The name is unknown.
        """
        serials = [identity.serial for identity in self._known(name)]
        self._write_list(self._revocations().also(serials, datetime.now(UTC)))
        return self._revocations()

    def _known(self, name: str) -> list[Identity]:
        found = [each.identity for each in self.issued() if each.identity.name == name and not each.is_revoked]
        if not found:
            names = ", ".join(sorted({each.identity.name for each in self.issued() if not each.is_revoked}))
            raise InvalidKeys(f"unknown identity '{name}' (identities of the lab '{self.lab}': {names or 'none'})")
        return found

    @property
    def _issued(self) -> Path:
        return self._folder.path / "issued"

    def _revocations(self) -> Revocations:
        return read_list(self._folder.revoked, self._certificate)

    def _write_list(self, revocations: Revocations) -> None:
        write_public(self._folder.revoked, make_list(revocations, self._key, self._certificate))

    def _check_free(self, to: Path) -> None:
        folder = KeyFolder(to)
        if folder.certificate.exists() or folder.key.exists():
            raise InvalidKeys(f"{to} already contains keys", help="choose another folder with `-o DIR`")
        if folder.authority.exists() and read_certificate(folder.authority) != self._certificate:
            raise InvalidKeys(f"{to} contains keys of another lab", help="choose another folder with `-o DIR`")

    def _issue(self, name: str, slot: CertificateSlot, to: Path, days: float, hosts: Sequence[str]) -> Identity:
        key = new_key()
        certificate = issue((self._key, self._certificate), key.public_key(), name, slot, days, hosts)
        folder = KeyFolder(to)
        make_folder(self._issued)
        make_folder(to)
        # Record the certificate first: one without a record could never be revoked.
        write_public(self._issued / f"{name}.{certificate.serial_number:x}.crt", certificate_pem(certificate))
        revocations = self._revocations()
        if slot.role in NAMED and revocations.names.get(slot) != name:
            self._write_list(revocations.named(slot, name))
        if to != self._folder.path:
            write_public(folder.authority, certificate_pem(self._certificate))
            write_public(folder.revoked, read_file(self._folder.revoked))
        write_private(folder.key, key_pem(key))
        write_public(folder.certificate, certificate_pem(certificate))
        return identity_of(certificate)


def _check_hosts(role: Role, hosts: Sequence[str]) -> None:
    """Check that only machines have hosts: the holder of such a key can pose as the machine at these hosts."""
    if hosts and not role.listens:
        raise InvalidKeys(
            f"unsupported host '{hosts[0]}' of the role {role.value}: people do not listen",
            help="leave out `--host`. For `seoro ui --listen`, give the machine an identity of its own: "
            f"`seoro keys add NAME --role site --host {hosts[0]}`",
        )


def init_authority(path: Path, lab: str, days: float = AUTHORITY_DAYS) -> Authority:
    """Create the authority of a lab in a folder.

    Raises:
        InvalidKeys: The folder already contains one, or the name is invalid.
    """
    check_name(lab, "a lab")
    folder = KeyFolder(path)
    if folder.authority.exists() or folder.authority_key.exists():
        raise InvalidKeys(f"{path} already contains lab keys", help="choose another folder with `--keys DIR`")
    key, certificate = make_authority(lab, days)
    make_folder(path)
    write_private(folder.authority_key, key_pem(key))
    write_public(folder.authority, certificate_pem(certificate))
    authority = Authority(folder, key, certificate)
    authority._write_list(Revocations(0, {}))
    return authority


def open_authority(path: Path) -> Authority:
    """Open the authority in a folder.

    Raises:
        InvalidKeys: The folder contains no key of a lab, or an invalid one.
    """
    folder = KeyFolder(path)
    if not folder.authority_key.exists():
        raise InvalidKeys(
            f"missing lab key in {path}",
            help="create it by `seoro keys init LAB`, or name its folder with `--authority DIR`",
        )
    return Authority(folder, *read_pair(folder.authority_key, folder.authority))
