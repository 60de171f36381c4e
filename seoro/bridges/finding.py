"""Finding the simulator node or the bridge that is meant, behind an endpoint."""

from __future__ import annotations

import anyio

from seoro import __version__
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import MAJOR, NAMESPACE, any_node_tokens, node_tokens, token_major, token_node
from seoro.errors import BackendError, BackendUnreachable, InvalidUse

TIMEOUT = 3.0  # [s]
LOOK_AGAIN = 0.05  # [s] between two looks


async def find_node(session: AsyncSession, endpoint: str, name: str | None, kind: str, start: str) -> str:
    """The name of a node that is reached by a session that is connected to an endpoint.

    Args:
        session: The session.
        endpoint: That endpoint, for messages.
        name: Which node it has to be; None for the only one there.
        kind: What it is, for messages, such as `simulator node`.
        start: How one is started, for the same.

    Raises:
        BackendUnreachable: There is none (yet).
        BackendError: There is one that speaks another version of the protocol.
        InvalidUse: There are several.
    """
    found: set[str] = set()
    with anyio.move_on_after(TIMEOUT):
        while True:
            # A session that follows tokens is told not all of them, or none, when it asks for a list of the same.
            found = {token_node(each)[0] for each in await session.list_tokens(node_tokens(NAMESPACE), TIMEOUT)}
            if found and name in (None, *found):
                break
            await anyio.sleep(LOOK_AGAIN)
    if not found:
        await _check_versions(session, endpoint)
    known = ", ".join(sorted(found))
    if not found or name not in (None, *found):
        which = kind if name is None else f"{kind} '{name}'"
        raise BackendUnreachable(
            f"there is no {which} at {endpoint}", help=f"there are {known}" if known else start
        )
    if name is None and len(found) > 1:
        raise InvalidUse(
            f"there are several nodes at {endpoint}: {known}", help="a lab file says by `name` which is meant"
        )
    return name or found.pop()


async def _check_versions(session: AsyncSession, endpoint: str) -> None:
    """Raise an error if nodes are there that speak another version of the protocol."""
    tokens = sorted(await session.list_tokens(any_node_tokens(NAMESPACE), TIMEOUT))
    others = [token for token in tokens if token_major(token) != str(MAJOR)]
    if others:
        node, version = token_node(others[0])[0], token_major(others[0])
        raise BackendError(
            f"the node '{node}' at {endpoint} speaks version {version} of the protocol; expected version {MAJOR}, "
            f"which this seoro speaks ({__version__})"
        )
