"""Who it is that asks for something, for others to read."""

from __future__ import annotations

import getpass
import socket


def whoami() -> str:
    """The user and the machine, as far as they are known."""
    try:
        return f"{getpass.getuser()}@{socket.gethostname()}"
    except (KeyError, OSError):  # a user without a name
        return socket.gethostname()
