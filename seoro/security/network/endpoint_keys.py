"""Keys for an endpoint. Endpoints outside this machine need keys.

Keys come from `--keys` or `SEORO_KEYS`, else from the user's own folder. Endpoints of this machine use keys only
on request.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges.session import Security, is_endpoint, is_local, is_secured
from seoro.bridges.session.brokered import current_broker
from seoro.bridges.session.endpoints import place_of
from seoro.bridges.wire.keys import MAJOR
from seoro.errors import UsageError
from seoro.security.keys.folder import chosen_folder, default_folder, read_keys
from seoro.security.keys.roles import NAMED, PEOPLE, Role

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys
    from seoro.security.keys.revocation import Revocations

ASKING: Final = frozenset({*PEOPLE, Role.EXECUTOR})  # may read the state of nodes
CLIENTS: Final = frozenset(PEOPLE)  # clients of executors
SERVING_NODES: Final = frozenset({Role.NODE})
SERVING_RUNS: Final = frozenset({Role.EXECUTOR})
ROUTING: Final = frozenset({Role.ROUTER})


def keys_for(endpoint: str, roles: frozenset[Role], folder: Path | None = None) -> Keys | None:
    """Return the keys to use at an endpoint; None if it needs none.

    Args:
        endpoint: Endpoint to listen at or connect to.
        roles: Accepted roles of the keys.
        folder: Folder of keys; by default `SEORO_KEYS`.

    Raises:
        UsageError: The endpoint needs keys that are missing, or it cannot use keys.
    """
    chosen = folder or chosen_folder()
    if not is_secured(endpoint):
        _check_local(endpoint)
        return None if chosen is None else read_keys(chosen, roles)
    return read_keys(chosen or default_folder(), roles)


def _check_local(endpoint: str) -> None:
    if is_endpoint(endpoint) and not is_local(endpoint):
        _, _, place = endpoint.partition("/")
        raise UsageError(
            f"{endpoint} is outside this machine, but not encrypted: others could read and send messages",
            help=f"use tls/{place} with keys (`seoro keys` creates them), or a tunnel (`ssh -L`) to an endpoint "
            "of this machine",
        )


def node_keys(endpoint: str, roles: frozenset[Role]) -> Keys | None:
    """Return the keys of a node, or of a client of nodes, at an endpoint.

    Endpoints of this machine never use keys: nodes accept unsigned requests there.

    Raises:
        UsageError: Keys are missing, or not valid there.
    """
    if not is_secured(endpoint):
        _check_local(endpoint)
        return None
    if (broker := current_broker()) is not None:
        from seoro.security.network.brokered_keys import brokered_keys  # noqa: PLC0415 - only in sandboxes

        return brokered_keys(broker, endpoint)
    return keys_for(endpoint, roles)


def check_reached(endpoint: str, security: Security | None) -> None:
    """Check whether a failed connection was rejected because of its keys.

    Raises:
        UsageError: It was; names the reason.
    """
    place = place_of(endpoint)
    if security is None or not isinstance(place, tuple):
        return
    from seoro.security.keys.diagnosis import why_refused  # noqa: PLC0415 - only where something is wrong

    if reason := why_refused(*place, security.authority, security.certificate, security.key):
        raise UsageError(f"{endpoint} answers, but {reason}", help=f"keys in use: {security.certificate.parent}")


def security_of(
    endpoint: str, keys: Keys | None, *, listens: bool = False, revoked: Revocations | None = None
) -> Security | None:
    """Return the security settings of a session at an endpoint; None without keys.

    Args:
        endpoint: The endpoint.
        keys: Result of `keys_for`.
        listens: Whether the session is the hub of others.
        revoked: Revoked keys, which a hub rejects, and names of executors and nodes.
    """
    if keys is None or not is_secured(endpoint) or current_broker() is not None:
        return None
    from seoro.security.keys.access_control import access_control  # noqa: PLC0415 - only where there are keys

    folder = keys.folder
    access = None
    if listens:
        own = {keys.identity.slot: keys.identity.name} if keys.identity.role in NAMED else {}
        known = ((), {}) if revoked is None else (revoked.slots, revoked.names)
        access = access_control(_requests_of_people(), known[0], {**known[1], **own})
    return Security(folder.authority, folder.certificate, folder.key, access)


def _requests_of_people() -> dict[Role, list[str]]:
    """Return the keys of the requests that people may send by their role; some may send more to nodes."""
    from seoro.bridges.executor.verbs import EXECUTOR_VERBS  # noqa: PLC0415 - only for routers
    from seoro.bridges.wire import NODE_VERBS  # noqa: PLC0415 - the same

    nodes = [f"seoro/{MAJOR}/*/node/*/cmd/{name}" for name, verb in NODE_VERBS.items() if verb.role is Role.VIEWER]
    return {
        role: [
            *(
                f"seoro/{MAJOR}/*/exec/*/cmd/{name}"
                for name, verb in EXECUTOR_VERBS.items()
                if role.includes(verb.role)
            ),
            *nodes,
        ]
        for role in PEOPLE
    }
