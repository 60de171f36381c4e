"""Endpoints of Zenoh, as people type them: what cannot be one is told, and not tried for a while."""

from __future__ import annotations

import re
from typing import Final

# What the Zenoh of PyPI offers, with a port: IPv6 addresses stand in brackets, `?` and `#` begin what is optional.
_NETWORK: Final = re.compile(r"(tcp|udp|tls|quic|ws)/(\[[^\]]+\]|[^\[\]:/?#]+):\d{1,5}([?#].*)?")
_LOCAL: Final = re.compile(r"unixsock-stream/.+")


def is_endpoint(text: str) -> bool:
    """Whether a text can be an endpoint of Zenoh: `tcp/127.0.0.1:7447`."""
    return bool(_NETWORK.fullmatch(text) or _LOCAL.fullmatch(text))


# Who reaches these is on this machine already.
_HERE: Final = re.compile(r"unixsock-stream/.+|[a-z]+/(127(\.\d{1,3}){3}|localhost|\[::1\]):\d+.*")


def is_local(endpoint: str) -> bool:
    """Whether an endpoint is one of this machine, which no other reaches."""
    return bool(_HERE.fullmatch(endpoint))


def is_secured(endpoint: str) -> bool:
    """Whether both ends at an endpoint prove who they are, and nobody else can read what they say."""
    return endpoint.startswith("tls/")
