"""Folders of keys, as those who take part have them.

ca.crt         certificate of the lab's authority
ca.key         its key: only where identities are made
identity.crt   who this is
identity.key   its key
revoked.crl    who is revoked, as far as it is known here
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.keys.errors import InvalidKeys
from seoro.keys.roles import Role

if TYPE_CHECKING:
    from cryptography import x509

    from seoro.keys.certificates import Identity, PrivateKey
    from seoro.keys.revocation import Revocations

VARIABLE: Final = "SEORO_KEYS"


@dataclass(frozen=True)
class KeyFolder:
    """A folder of keys; what of it is not there, is not."""

    path: Path

    @property
    def authority(self) -> Path:
        """Certificate of the lab's authority."""
        return self.path / "ca.crt"

    @property
    def authority_key(self) -> Path:
        """Key of the lab's authority."""
        return self.path / "ca.key"

    @property
    def certificate(self) -> Path:
        """Certificate of the identity."""
        return self.path / "identity.crt"

    @property
    def key(self) -> Path:
        """Key of the identity."""
        return self.path / "identity.key"

    @property
    def revoked(self) -> Path:
        """List of those who are revoked."""
        return self.path / "revoked.crl"

    def revoked_stamp(self) -> tuple[int, int, int] | None:
        """Return what changes with the list of those who are revoked; None if the folder has none."""
        try:
            found = self.revoked.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino


@dataclass(frozen=True)
class Keys:
    """Keys with which to take part. Made by `read_keys`.

    Attributes:
        revoked: Who is revoked, where the folder cannot be read, as in a sandbox; None to read the list in it.
    """

    folder: KeyFolder
    authority: x509.Certificate
    certificate: x509.Certificate
    key: PrivateKey
    identity: Identity
    revoked: Revocations | None = None


def default_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Where keys lie, unless somebody says otherwise."""
    config = environment.get("XDG_CONFIG_HOME")
    return (Path(config) if config else Path.home() / ".config") / "seoro" / "keys"


def chosen_folder(environment: Mapping[str, str] = os.environ) -> Path | None:
    """The folder of keys that somebody has asked for by `SEORO_KEYS`."""
    chosen = environment.get(VARIABLE)
    return Path(chosen) if chosen else None


def read_keys(path: Path, roles: frozenset[Role] | None = None) -> Keys:
    """The keys in a folder, which are whole, valid now, and for one of some roles.

    Raises:
        InvalidKeys: They are not.
    """
    from seoro.keys.certificates import check_issued, check_time, identity_of  # noqa: PLC0415 - on demand
    from seoro.keys.files import read_certificate, read_pair  # noqa: PLC0415 - the same

    folder = KeyFolder(path)
    if not folder.certificate.exists():
        found = "the key of the lab, but no identity" if folder.authority_key.exists() else "no keys"
        raise InvalidKeys(
            f"{path} contains {found}",
            help="`seoro keys add NAME --role ROLE` makes the keys of an identity, where the lab's key is",
        )
    authority = read_certificate(folder.authority)
    key, certificate = read_pair(folder.key, folder.certificate)
    try:
        check_issued(certificate, authority)
    except InvalidKeys as error:
        raise InvalidKeys(
            f"{folder.certificate}: {error}", help=f"it does not belong to {folder.authority}"
        ) from None
    identity = identity_of(certificate)
    check_time(identity, datetime.now(UTC))
    if roles is not None and identity.role not in roles:
        wanted = " or ".join(sorted(role.value for role in roles))
        raise InvalidKeys(
            f"the keys in {path} are those of {identity}, and cannot be used as {wanted}",
            help="`--keys DIR` or SEORO_KEYS names others",
        )
    return Keys(folder, authority, certificate, key, identity)
