"""Name of the current user, for other users of shared robots."""

from __future__ import annotations

import getpass
import socket


def whoami() -> str:
    """Return `user@host`, or the host if the user has no name."""
    try:
        return f"{getpass.getuser()}@{socket.gethostname()}"
    except (KeyError, OSError):  # a user without a name
        return socket.gethostname()
