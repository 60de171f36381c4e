"""Which keys belong to an endpoint: outside this machine, nothing is said without.

Keys are those of `--keys` or `SEORO_KEYS`, else those of the user's own folder. At endpoints of this machine they
are used only if somebody has asked for them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges.session import Security, is_endpoint, is_local, is_secured
from seoro.bridges.session.brokered import broker_here
from seoro.errors import InvalidUse
from seoro.keys.folder import chosen_folder, default_folder, read_keys
from seoro.keys.roles import NAMED, PEOPLE, Role

if TYPE_CHECKING:
    from seoro.keys.folder import Keys
    from seoro.keys.revocation import Revocations

ASKING: Final = frozenset({*PEOPLE, Role.EXECUTOR})  # of nodes, how they are
CLIENTS: Final = frozenset(PEOPLE)  # of executors
SERVING_NODES: Final = frozenset({Role.NODE})
SERVING_RUNS: Final = frozenset({Role.EXECUTOR})
_NETWORK: Final = re.compile(r"tls/(?P<host>\[[^\]]+\]|[^:]+):(?P<port>\d+)")
ROUTING: Final = frozenset({Role.ROUTER})


def keys_for(endpoint: str, roles: frozenset[Role], folder: Path | None = None) -> Keys | None:
    """The keys to use at an endpoint; None if none are needed.

    Args:
        endpoint: Where is listened, or connected to.
        roles: What whoever does so takes part as.
        folder: That somebody has asked for; by default that of `SEORO_KEYS`.

    Raises:
        InvalidUse: Others could reach it, and there are no keys, or keys are of no use there.
    """
    chosen = folder or chosen_folder()
    if not is_secured(endpoint):
        _check_local(endpoint)
        return None if chosen is None else read_keys(chosen, roles)
    return read_keys(chosen or default_folder(), roles)


def _check_local(endpoint: str) -> None:
    if is_endpoint(endpoint) and not is_local(endpoint):
        _, _, place = endpoint.partition("/")
        raise InvalidUse(
            f"{endpoint} is outside this machine, where others could listen to what is said and say something",
            help=f"use tls/{place} and keys, which `seoro keys` makes; or an endpoint of this machine and a "
            "tunnel, `ssh -L`",
        )


def node_keys(endpoint: str, roles: frozenset[Role]) -> Keys | None:
    """The keys of a node, or of one who asks nodes, at an endpoint.

    At endpoints of this machine there are none, whatever keys there are: nodes take no seals there.

    Raises:
        InvalidUse: There are none, or they are of no use there.
    """
    if not is_secured(endpoint):
        _check_local(endpoint)
        return None
    if (broker := broker_here()) is not None:
        from seoro.bridges.brokered_keys import brokered_keys  # noqa: PLC0415 - only in sandboxes

        return brokered_keys(broker, endpoint)
    return keys_for(endpoint, roles)


def check_reached(endpoint: str, security: Security | None) -> None:
    """Say why a connection with keys does not come about, if it is because of the keys.

    Raises:
        InvalidUse: It is.
    """
    match = _NETWORK.match(endpoint)
    if security is None or match is None:
        return
    from seoro.keys.diagnosing import why_refused  # noqa: PLC0415 - only where something is wrong

    host = match["host"].strip("[]")
    if reason := why_refused(host, int(match["port"]), security.authority, security.certificate, security.key):
        raise InvalidUse(
            f"{endpoint} answers, but {reason}", help=f"the keys here are {security.certificate.parent}"
        )


def security_of(
    endpoint: str, keys: Keys | None, *, listens: bool = False, revoked: Revocations | None = None
) -> Security | None:
    """What a session at an endpoint needs of keys.

    Args:
        endpoint: The endpoint.
        keys: Of `keys_for`.
        listens: Whether the session is the hub of others.
        revoked: Who gets nothing there, and the names that belong to some.
    """
    if keys is None or not is_secured(endpoint) or broker_here() is not None:
        return None
    from seoro.keys.access import access_control  # noqa: PLC0415 - only where there are keys

    folder = keys.folder
    access = None
    if listens:
        own = {keys.identity.seat: keys.identity.name} if keys.identity.role in NAMED else {}
        known = ((), {}) if revoked is None else (revoked.seats, revoked.names)
        access = access_control(known[0], {**known[1], **own})
    return Security(folder.authority, folder.certificate, folder.key, access)
