"""Why a connection with keys does not come about: tried once more, by a library that says it."""

from __future__ import annotations

import socket
import ssl
from pathlib import Path
from typing import Final

TIMEOUT: Final = 2.0  # [s]
_SAYS: Final = 0.3  # [s] in which a server says that it does not want this client
_REASONS: Final = {
    "CERTIFICATE_VERIFY_FAILED": "its certificate is not valid here",
    "UNKNOWN_CA": "it belongs to another lab: its authority has not signed these keys",
    "DECRYPT_ERROR": "it belongs to another lab: its authority has not signed these keys",
    "BAD_CERTIFICATE": "it does not accept the certificate in these keys",
    "CERTIFICATE_EXPIRED": "the certificate in these keys has expired, by its clock",
    "CERTIFICATE_REQUIRED": "it asks for keys",
    "WRONG_VERSION_NUMBER": "it does not speak TLS",
}
_VERIFYING: Final = {
    10: "its certificate has expired: `seoro keys renew`, where the key of its lab is",
    9: "its certificate is not valid yet: the clocks of the two machines differ",
    62: "its certificate is not for this host name: `seoro keys renew NAME --host HOST` makes one that is",
    64: "its certificate is not for this address: `seoro keys renew NAME --host ADDRESS` makes one that is",
}
_OTHER_LAB: Final = "it belongs to another lab: its certificate was not signed by the authority of these keys"


def why_refused(host: str, port: int, authority: Path, certificate: Path, key: Path) -> str | None:
    """Why one who listens there does not take these keys, or has none that hold; None if that is not why.

    Args:
        host: Name or address.
        port: TCP port.
        authority: File with the certificate of the lab.
        certificate: File with our own.
        key: File with the key to it.
    """
    context = ssl.create_default_context(cafile=authority)
    context.load_cert_chain(certificate, key)
    try:
        with (
            socket.create_connection((host, port), TIMEOUT) as plain,
            context.wrap_socket(plain, server_hostname=host) as secured,
        ):
            secured.settimeout(_SAYS)
            secured.recv(1)
    except ssl.SSLCertVerificationError as error:
        return _VERIFYING.get(error.verify_code, _OTHER_LAB)
    except ssl.SSLError as error:
        reason = error.reason or ""
        said = next((text for part, text in _REASONS.items() if part in reason), None)
        return said or f"it breaks off the handshake ({reason or error})"
    except OSError:  # nobody is there, or it has nothing to say against them
        return None
    return None
