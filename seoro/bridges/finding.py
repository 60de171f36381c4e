"""Search for a simulator node or a bridge at an endpoint."""

from __future__ import annotations

from seoro import __version__
from seoro.bridges.naming import wait_for_tokens
from seoro.bridges.session import AsyncSession
from seoro.bridges.wire.keys import MAJOR, NAMESPACE, any_node_tokens, node_tokens, token_major, token_node
from seoro.errors import BackendError, BackendUnreachable, UsageError

TIMEOUT = 3.0  # [s]


async def find_node(session: AsyncSession, endpoint: str, name: str | None, kind: str, start: str) -> str:
    """Return the name of a node that a session reaches.

    Args:
        session: The session.
        endpoint: Endpoint, for messages.
        name: Name of the node; None for the only one.
        kind: Kind of node, for messages, such as `simulator node`.
        start: Command that starts such a node, for messages.

    Raises:
        BackendUnreachable: No such node was found (yet).
        BackendError: A node speaks another version of the protocol.
        UsageError: Several nodes were found.
    """

    def is_enough(tokens: frozenset[str]) -> bool:
        return bool(tokens) and name in (None, *_names(tokens))

    found = _names(await wait_for_tokens(session, node_tokens(NAMESPACE), TIMEOUT, is_enough))
    if not found:
        await _check_versions(session, endpoint)
    known = ", ".join(sorted(found))
    if not found or name not in (None, *found):
        which = kind if name is None else f"{kind} '{name}'"
        raise BackendUnreachable(
            f"no {which} found at {endpoint}", help=f"nodes there: {known}" if known else start
        )
    if name is None and len(found) > 1:
        raise UsageError(f"several nodes at {endpoint}: {known}", help="select one by `name` in the lab file")
    return name or found.pop()


def _names(tokens: frozenset[str]) -> set[str]:
    return {token_node(token)[0] for token in tokens}


async def _check_versions(session: AsyncSession, endpoint: str) -> None:
    """Raise an error if nodes speak another version of the protocol."""
    tokens = sorted(await session.list_tokens(any_node_tokens(NAMESPACE), TIMEOUT))
    others = [token for token in tokens if token_major(token) != str(MAJOR)]
    if others:
        node, version = token_node(others[0])[0], token_major(others[0])
        raise BackendError(
            f"the node '{node}' at {endpoint} speaks version {version} of the protocol; expected version {MAJOR} "
            f"(seoro {__version__})"
        )
