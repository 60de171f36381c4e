"""Validation of Zenoh endpoints, since Zenoh reports invalid ones late."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

# Transports of the Zenoh of PyPI with a port; IPv6 addresses stand in brackets, and `?` and `#` begin options.
_NETWORK: Final = re.compile(r"(tcp|udp|tls|quic|ws)/(\[[^\]]+\]|[^\[\]:/?#]+):\d{1,5}([?#].*)?")
_LOCAL: Final = re.compile(r"unixsock-stream/.+")


def is_endpoint(text: str) -> bool:
    """Whether a text is a valid endpoint of Zenoh, such as `tcp/127.0.0.1:7447`."""
    return bool(_NETWORK.fullmatch(text) or _LOCAL.fullmatch(text))


_PORT: Final = re.compile(r"(tcp|tls|ws)/(?P<host>\[[^\]]+\]|[^:]+):(?P<port>\d+).*")
_FILE: Final = re.compile(r"unixsock-stream/(?P<path>[^?#]+).*")


def place_of(endpoint: str) -> tuple[str, int] | Path | None:
    """Return the host and TCP port, or the socket file, of an endpoint; None for other transports."""
    if match := _FILE.fullmatch(endpoint):
        return Path(match["path"])
    match = _PORT.fullmatch(endpoint)
    return None if match is None else (match["host"].strip("[]"), int(match["port"]))


# addresses reachable from this machine only
_HERE: Final = re.compile(r"unixsock-stream/.+|[a-z]+/(127(\.\d{1,3}){3}|localhost|\[::1\]):\d+.*")


def is_local(endpoint: str) -> bool:
    """Whether an endpoint is reachable from this machine only."""
    return bool(_HERE.fullmatch(endpoint))


def is_secured(endpoint: str) -> bool:
    """Whether TLS protects an endpoint: both ends are authenticated, and messages are encrypted."""
    return endpoint.startswith("tls/")
