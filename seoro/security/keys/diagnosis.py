"""Diagnosis of failed connections: a second TLS handshake, by a library that reports the reason."""

from __future__ import annotations

import socket
import ssl
from pathlib import Path
from typing import Final

TIMEOUT: Final = 2.0  # [s]
_REJECTION_TIMEOUT: Final = 0.3  # [s] in which a server rejects this client
_REASONS: Final = {
    "CERTIFICATE_VERIFY_FAILED": "its certificate is not valid here",
    "UNKNOWN_CA": "it belongs to another lab: its authority has not signed these keys",
    "DECRYPT_ERROR": "it belongs to another lab: its authority has not signed these keys",
    "BAD_CERTIFICATE": "it does not accept the certificate in these keys",
    "CERTIFICATE_EXPIRED": "the certificate in these keys has expired, by its clock",
    "CERTIFICATE_REQUIRED": "it requires keys",
    "WRONG_VERSION_NUMBER": "it does not speak TLS",
}
_VERIFYING: Final = {
    10: "its certificate has expired: run `seoro keys renew` where the key of its lab is",
    9: "its certificate is not valid yet: the clocks of the two machines differ",
    62: "its certificate is not valid for this host name: run `seoro keys renew NAME --host HOST`",
    64: "its certificate is not valid for this address: run `seoro keys renew NAME --host ADDRESS`",
}
_OTHER_LAB: Final = "it belongs to another lab: its certificate was not signed by the authority of these keys"


def why_refused(host: str, port: int, authority: Path, certificate: Path, key: Path) -> str | None:
    """Return the reason why a server rejects these keys, or has invalid ones; None for other failures.

    Args:
        host: Name or address of the server.
        port: TCP port of the server.
        authority: File with the certificate of the lab.
        certificate: File with the own certificate.
        key: File with the private key.
    """
    context = ssl.create_default_context(cafile=authority)
    context.load_cert_chain(certificate, key)
    try:
        with (
            socket.create_connection((host, port), TIMEOUT) as plain,
            context.wrap_socket(plain, server_hostname=host) as secured,
        ):
            secured.settimeout(_REJECTION_TIMEOUT)
            secured.recv(1)
    except ssl.SSLCertVerificationError as error:
        return _VERIFYING.get(error.verify_code, _OTHER_LAB)
    except ssl.SSLError as error:
        reason = error.reason or ""
        known = next((text for part, text in _REASONS.items() if part in reason), None)
        return known or f"it aborts the TLS handshake ({reason or error})"
    except OSError:  # the server does not answer, or accepts the keys
        return None
    return None
