"""Keys in a sandbox: certificates and list of revoked keys are copies, the private key stays with the broker."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from seoro.bridges.session.brokered import CREDENTIALS, SIGN, Broker
from seoro.bridges.session.errors import SessionError
from seoro.errors import UsageError
from seoro.security.keys.folder import KeyFolder, Keys

if TYPE_CHECKING:
    from seoro.security.keys.certificates import PrivateKey


class _RemoteKey:
    """A private key that the broker uses on request.

    Args:
        broker: Connection to the broker.
    """

    def __init__(self, broker: Broker) -> None:
        self._broker = broker

    def sign(self, data: bytes, _algorithm: Any) -> bytes:
        """Return the signature of some bytes."""
        signature: bytes = self._broker.ask(SIGN, data)
        return signature


def brokered_keys(broker: Broker, endpoint: str) -> Keys | None:
    """Return the keys for an endpoint; None if it needs none.

    Raises:
        UsageError: Keys are missing, or not valid there.
    """
    from cryptography import x509  # noqa: PLC0415 - only where there are keys

    from seoro.security.keys.certificates import identity_of  # noqa: PLC0415 - the same
    from seoro.security.keys.revocation import parse_list  # noqa: PLC0415 - the same

    try:
        found = broker.ask(CREDENTIALS, endpoint)
    except SessionError as error:
        raise UsageError(str(error)) from error
    if found is None:
        return None
    authority, certificate = map(x509.load_pem_x509_certificate, found[:2])
    key = cast("PrivateKey", _RemoteKey(broker))
    revoked = parse_list(found[2], authority)
    return Keys(KeyFolder(Path()), authority, certificate, key, identity_of(certificate), revoked)
