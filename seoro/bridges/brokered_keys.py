"""Keys of a process in a sandbox: its certificates, who is revoked, and a key that the broker uses for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from seoro.bridges.session.brokered import CREDENTIALS, SIGN, Broker
from seoro.bridges.session.errors import SessionError
from seoro.errors import InvalidUse
from seoro.keys.folder import KeyFolder, Keys

if TYPE_CHECKING:
    from seoro.keys.certificates import PrivateKey


class _RemoteKey:
    """A private key that is elsewhere.

    Args:
        broker: Has it.
    """

    def __init__(self, broker: Broker) -> None:
        self._broker = broker

    def sign(self, said: bytes, _algorithm: Any) -> bytes:
        """The signature of some bytes."""
        signature: bytes = self._broker.ask(SIGN, said)
        return signature


def brokered_keys(broker: Broker, endpoint: str) -> Keys | None:
    """The keys to use at an endpoint; None if there are none to be used.

    Raises:
        InvalidUse: There are none, or they are of no use there.
    """
    from cryptography import x509  # noqa: PLC0415 - only where there are keys

    from seoro.keys.certificates import identity_of  # noqa: PLC0415 - the same
    from seoro.keys.revocation import parse_list  # noqa: PLC0415 - the same

    try:
        found = broker.ask(CREDENTIALS, endpoint)
    except SessionError as error:
        raise InvalidUse(str(error)) from error
    if found is None:
        return None
    authority, certificate = map(x509.load_pem_x509_certificate, found[:2])
    key = cast("PrivateKey", _RemoteKey(broker))
    revoked = parse_list(found[2], authority)
    return Keys(KeyFolder(Path()), authority, certificate, key, identity_of(certificate), revoked)
