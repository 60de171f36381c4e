"""Processes that listen at an endpoint, but are late: on a busy machine, an answer may take seconds."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import anyio

from seoro.bridges.session.endpoints import is_secured, place_of

PATIENCE: Final = 5.0  # [s] for the answer of a process that listens
_LIMIT: Final = 1.0  # [s] for a connection


async def may_be_late(endpoint: object) -> bool:
    """Return whether a process listens at an endpoint that has not answered.

    With keys, it may have rejected them, which a user should not wait for.
    """
    if not isinstance(endpoint, str) or is_secured(endpoint):
        return False
    try:
        with anyio.fail_after(_LIMIT):
            match place_of(endpoint):
                case Path() as path:
                    await (await anyio.connect_unix(path)).aclose()
                case (host, port):
                    await (await anyio.connect_tcp(host, port)).aclose()
                case _:
                    return False
    except (OSError, TimeoutError):
        return False
    return True
