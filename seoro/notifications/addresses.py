"""URLs of notifications. They may have secrets, so messages have their scheme and host only."""

from __future__ import annotations

import os
from ipaddress import ip_address
from typing import Final, NamedTuple
from urllib.parse import SplitResult, unquote, urlsplit

from seoro.errors import UsageError

PLAIN: Final = "SEORO_NOTIFY_HTTP"
"""Variable of the environment that allows plain HTTP beyond this machine, with the value 1."""

_LONGEST: Final = 2000  # [characters]


class Address(NamedTuple):
    """A checked URL.

    Attributes:
        url: URL without credentials.
        shown: Its scheme and host, for messages.
        credentials: User and password of the URL; None without them.
        is_local: Whether its host is this machine.
    """

    url: str
    shown: str
    credentials: tuple[str, str] | None
    is_local: bool


def read_address(text: str) -> Address:
    """Check a URL.

    Raises:
        UsageError: It is invalid, or plain HTTP beyond this machine without permission.
    """
    try:
        parts = urlsplit(text)
        host, port = parts.hostname or "", parts.port
    except ValueError:
        raise _invalid("it is malformed") from None
    if len(text) > _LONGEST or not text.isascii() or not text.isprintable() or " " in text:
        raise _invalid(f"expected at most {_LONGEST} printable ASCII characters, without blanks")
    if parts.scheme not in {"http", "https"} or not host:
        raise _invalid("expected https://HOST/PATH")
    is_local = _is_loopback(host)
    place = (f"[{host}]" if ":" in host else host) + ("" if port is None else f":{port}")
    shown = f"{parts.scheme}://{place}"
    if parts.scheme == "http" and not is_local and os.environ.get(PLAIN) != "1":
        raise UsageError(
            f"notifications to {shown} would be readable on the network", help=f"use https, or set {PLAIN}=1"
        )
    url = parts._replace(netloc=place, fragment="").geturl()
    return Address(
        url, f"{shown}/..." if parts.path.strip("/") or parts.query else shown, _credentials(parts), is_local
    )


def _invalid(reason: str) -> UsageError:
    return UsageError(f"invalid URL for notifications: {reason}", help="for example https://ci.example.org/hook")


def _credentials(parts: SplitResult) -> tuple[str, str] | None:
    return None if parts.username is None else (unquote(parts.username), unquote(parts.password or ""))


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
