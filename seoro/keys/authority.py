"""The authority of a lab: makes identities, and remembers all that it has made.

ca.crt  ca.key            its key
issued/NAME.SERIAL.crt    every certificate that it has signed
revoked.crl               those that it has taken back
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from cryptography import x509

from seoro.keys.certificates import (
    SEATS,
    Identity,
    PrivateKey,
    Seat,
    certificate_pem,
    check_name,
    identity_of,
    issue,
    key_pem,
    lab_of,
    make_authority,
    new_key,
)
from seoro.keys.errors import InvalidKeys
from seoro.keys.files import make_folder, read_certificate, read_file, read_pair, write_private, write_public
from seoro.keys.folder import KeyFolder
from seoro.keys.revocation import Revocations, make_list, read_list
from seoro.keys.roles import NAMED, Role

AUTHORITY_DAYS: Final = 3650.0
IDENTITY_DAYS: Final = 365.0


@dataclass(frozen=True)
class Issued:
    """An identity that was made."""

    identity: Identity
    is_revoked: bool


class Authority:
    """The authority whose key lies in a folder. Made by `init_authority` and `open_authority`."""

    def __init__(self, folder: KeyFolder, key: PrivateKey, certificate: x509.Certificate) -> None:
        self._folder = folder
        self._key = key
        self._certificate = certificate

    @property
    def lab(self) -> str:
        """Name of the lab."""
        return lab_of(self._certificate)

    def issued(self) -> list[Issued]:
        """All that was made, by name and time."""
        revoked = self._revocations()
        identities = [identity_of(read_certificate(path)) for path in self._issued.glob("*.crt")]
        identities.sort(key=lambda identity: (identity.name, identity.begins))
        return [Issued(identity, revoked.has(identity.serial)) for identity in identities]

    def add(
        self, name: str, role: Role, to: Path, days: float = IDENTITY_DAYS, hosts: Sequence[str] = ()
    ) -> Identity:
        """Make an identity, in a folder that is carried to whoever it is for.

        Args:
            name: Of the identity; no other has it that is not revoked.
            role: What it takes part as.
            to: The folder; it may be that of the authority.
            days: For which the certificate is valid.
            hosts: Where others reach it, if they do.

        Raises:
            InvalidKeys: The name is taken, the folder has an identity, or there is no room.
        """
        check_name(name, "an identity")
        if hosts and not role.listens:
            raise InvalidKeys(f"nobody connects to a {role.value}", help="leave out `--host`")
        issued = self.issued()
        if any(each.identity.name == name and not each.is_revoked for each in issued):
            raise InvalidKeys(
                f"there is a '{name}' already", help=f"`seoro keys renew {name}` or `seoro keys revoke {name}`"
            )
        number = 1 + max((each.identity.seat.number for each in issued if each.identity.role is role), default=0)
        if number > SEATS:
            raise InvalidKeys(
                f"the lab '{self.lab}' has had {SEATS} identities with the role {role.value}, which is all it can",
                help="begin anew with `seoro keys init` in another folder, and make new keys for all",
            )
        self._check_free(to)
        return self._issue(name, Seat(role, number), to, days, hosts)

    def renew(self, name: str, to: Path, days: float = IDENTITY_DAYS, hosts: Sequence[str] = ()) -> Identity:
        """A new key and a new certificate for an identity; those before it stay valid until they expire.

        Raises:
            InvalidKeys: There is none of that name.
        """
        identity = self._known(name)[-1]
        kept = hosts or [host for host in identity.hosts if identity.role.listens]
        return self._issue(name, identity.seat, to, days, kept)

    def revoke(self, name: str) -> Revocations:
        """Take an identity back, with all certificates that it has had.

        Raises:
            InvalidKeys: There is none of that name.
        """
        serials = [identity.serial for identity in self._known(name)]
        self._write_list(self._revocations().also(serials, datetime.now(UTC)))
        return self._revocations()

    def _known(self, name: str) -> list[Identity]:
        found = [each.identity for each in self.issued() if each.identity.name == name and not each.is_revoked]
        if not found:
            names = ", ".join(sorted({each.identity.name for each in self.issued() if not each.is_revoked}))
            raise InvalidKeys(f"there is no '{name}' in the lab '{self.lab}'", help=f"there are {names or 'none'}")
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
            raise InvalidKeys(f"there are keys in {to} already", help="`-o DIR` names another folder")
        if folder.authority.exists() and read_certificate(folder.authority) != self._certificate:
            raise InvalidKeys(f"{to} has the keys of another lab", help="`-o DIR` names another folder")

    def _issue(self, name: str, seat: Seat, to: Path, days: float, hosts: Sequence[str]) -> Identity:
        key = new_key()
        certificate = issue((self._key, self._certificate), key.public_key(), name, seat, days, hosts)
        folder = KeyFolder(to)
        make_folder(self._issued)
        make_folder(to)
        # First what is remembered: a certificate that is nowhere known could never be revoked.
        write_public(self._issued / f"{name}.{certificate.serial_number:x}.crt", certificate_pem(certificate))
        revocations = self._revocations()
        if seat.role in NAMED and revocations.names.get(seat) != name:
            self._write_list(revocations.named(seat, name))
        if to != self._folder.path:
            write_public(folder.authority, certificate_pem(self._certificate))
            write_public(folder.revoked, read_file(self._folder.revoked))
        write_private(folder.key, key_pem(key))
        write_public(folder.certificate, certificate_pem(certificate))
        return identity_of(certificate)


def init_authority(path: Path, lab: str, days: float = AUTHORITY_DAYS) -> Authority:
    """Make the key of a lab, in a folder that has none.

    Raises:
        InvalidKeys: It has one, or the name cannot be.
    """
    check_name(lab, "a lab")
    folder = KeyFolder(path)
    if folder.authority.exists() or folder.authority_key.exists():
        raise InvalidKeys(f"there are keys of a lab in {path} already", help="`--keys DIR` names another folder")
    key, certificate = make_authority(lab, days)
    make_folder(path)
    write_private(folder.authority_key, key_pem(key))
    write_public(folder.authority, certificate_pem(certificate))
    authority = Authority(folder, key, certificate)
    authority._write_list(Revocations(0, {}))
    return authority


def open_authority(path: Path) -> Authority:
    """The authority whose key lies in a folder.

    Raises:
        InvalidKeys: There is none.
    """
    folder = KeyFolder(path)
    if not folder.authority_key.exists():
        raise InvalidKeys(
            f"the key of a lab is not in {path}",
            help="`seoro keys init LAB` makes it; `--keys DIR` says where it is",
        )
    return Authority(folder, *read_pair(folder.authority_key, folder.authority))
