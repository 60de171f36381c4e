"""Security settings of Zenoh: mutual TLS and access control."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from seoro.deferred import dataclass


@dataclass(frozen=True)
class Security:
    """Files with the keys of a session.

    Attributes:
        authority: Certificate of the authority, which signs all other certificates.
        certificate: Certificate of this side.
        key: Private key of the certificate.
        access: Zenoh's access control for connecting clients.
    """

    authority: Path
    certificate: Path
    key: Path
    access: Mapping[str, Any] | None = None


def secured_settings(settings: dict[str, Any], security: Security) -> None:
    """Add keys to the settings of a session."""
    key, certificate = str(security.key), str(security.certificate)
    tls: dict[str, Any] = {
        "root_ca_certificate": str(security.authority),
        "enable_mtls": True,
        "connect_private_key": key,
        "connect_certificate": certificate,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }
    link = settings["transport"]["link"]
    if settings["listen"]["endpoints"]:
        tls |= {"listen_private_key": key, "listen_certificate": certificate}
        link["protocols"] = ["tls"]  # no connection without keys
    link["tls"] = tls
    if security.access is not None:
        settings["access_control"] = dict(security.access)
