"""Finding the simulator node or the bridge that is meant, behind an endpoint."""

from __future__ import annotations

import anyio

from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import NAMESPACE, node_tokens, token_node
from seoro.errors import BackendUnreachable, InvalidUse

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
