"""Folders of keys, with these files:

- `ca.crt`: certificate of the lab's authority.
- `ca.key`: private key of the authority, only in the folder of the authority.
- `identity.crt`, `identity.key`: certificate and private key of the identity.
- `revoked.crl`: list of revoked certificates.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.deferred import dataclass
from seoro.security.keys import VARIABLE
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.roles import Role

if TYPE_CHECKING:
    from cryptography import x509

    from seoro.security.keys.certificates import Identity, PrivateKey
    from seoro.security.keys.revocation import Revocations


class KeyFolder:
    """Paths in a folder of keys; each file may be missing.

    Attributes:
        path: The folder.
        authority: Certificate of the lab's authority.
        authority_key: Key of the lab's authority.
        certificate: Certificate of the identity.
        key: Key of the identity.
        revoked: List of revoked certificates.
    """

    def __init__(self, path: Path) -> None:
        self.path: Final = path
        self.authority: Final = path / "ca.crt"
        self.authority_key: Final = path / "ca.key"
        self.certificate: Final = path / "identity.crt"
        self.key: Final = path / "identity.key"
        self.revoked: Final = path / "revoked.crl"

    def revoked_stamp(self) -> tuple[int, int, int] | None:
        """Return a stamp that changes with the list of revoked certificates; None without a list."""
        try:
            found = self.revoked.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino


@dataclass(frozen=True)
class Keys:
    """Keys of an identity. Created by `read_keys`.

    Attributes:
        revoked: Revoked certificates in a sandbox, which cannot read the folder; None to read the list there.
    """

    folder: KeyFolder
    authority: x509.Certificate
    certificate: x509.Certificate
    key: PrivateKey
    identity: Identity
    revoked: Revocations | None = None


def default_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the default folder of keys."""
    config = environment.get("XDG_CONFIG_HOME")
    return (Path(config) if config else Path.home() / ".config") / "seoro" / "keys"


def chosen_folder(environment: Mapping[str, str] = os.environ) -> Path | None:
    """Return the folder of keys in `SEORO_KEYS`; None if it is unset."""
    chosen = environment.get(VARIABLE)
    return Path(chosen) if chosen else None


def read_keys(path: Path, roles: frozenset[Role] | None = None) -> Keys:
    """Read the keys in a folder, and check that they are valid now, for one of `roles`.

    Raises:
        InvalidKeys: Keys are missing, invalid, expired or of another role.
    """
    from seoro.security.keys.certificates import check_issued, check_time, identity_of  # noqa: PLC0415 - on demand
    from seoro.security.keys.files import read_certificate, read_pair  # noqa: PLC0415 - the same

    folder = KeyFolder(path)
    if not folder.certificate.exists():
        found = "the key of the lab, but no identity" if folder.authority_key.exists() else "no keys"
        raise InvalidKeys(
            f"{path} contains {found}",
            help="create an identity by `seoro keys add NAME --role ROLE` where the lab key is",
        )
    authority = read_certificate(folder.authority)
    key, certificate = read_pair(folder.key, folder.certificate)
    try:
        check_issued(certificate, authority)
    except InvalidKeys as error:
        raise InvalidKeys(f"{folder.certificate}: {error}", help=f"it does not match {folder.authority}") from None
    identity = identity_of(certificate)
    check_time(identity, datetime.now(UTC))
    if roles is not None and identity.role not in roles:
        wanted = " or ".join(sorted(role.value for role in roles))
        raise InvalidKeys(
            f"the keys in {path} are those of {identity}; expected role: {wanted}",
            help="choose other keys with `--keys DIR` or SEORO_KEYS",
        )
    return Keys(folder, authority, certificate, key, identity)
