"""Roles, and the one table of what each may ask of executors and nodes."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import Final


class Role(StrEnum):
    """What an identity takes part as. The order is part of serial numbers: new roles come last."""

    VIEWER = "viewer"  # looks at runs
    OPERATOR = "operator"  # submits and stops runs, moves robots
    ADMIN = "admin"  # everything that can be asked for
    EXECUTOR = "executor"  # runs scenarios, and asks nodes on their behalf
    NODE = "node"  # a simulator, or a bridge to robots
    ROUTER = "router"  # passes on what others say

    @property
    def listens(self) -> bool:
        """Whether others connect to it."""
        return self in LISTENING

    @property
    def number(self) -> int:
        """Its place in serial numbers."""
        return list(Role).index(self)


LISTENING: Final = frozenset({Role.EXECUTOR, Role.NODE, Role.ROUTER})
NAMED: Final = frozenset({Role.EXECUTOR, Role.NODE})  # asked by their names
PEOPLE: Final = (Role.VIEWER, Role.OPERATOR, Role.ADMIN)  # each may what those before it may

# What may be asked of executors, by the least role that may ask for it.
_EXECUTOR_VERBS: Final[Mapping[Role, frozenset[str]]] = MappingProxyType(
    {
        Role.VIEWER: frozenset(
            {"challenge", "describe", "list_runs", "get_run", "records", "list_files", "read_file"}
        ),
        Role.OPERATOR: frozenset({"missing_blobs", "put_blob", "submit", "dry_run", "stop_run", "remove_run"})
        | {"look", "emergency_stop", "release_stop"},
        Role.ADMIN: frozenset({"revoke"}),
    }
)
# What viewers may ask nodes, of which all else is for those who move robots.
NODE_READING: Final = frozenset({"challenge", "get_lab_state"})
MOVING: Final = frozenset({Role.OPERATOR, Role.ADMIN, Role.EXECUTOR})  # simulators and robots
READING: Final = _EXECUTOR_VERBS[Role.VIEWER]  # changes nothing
STOPPING: Final = frozenset({"stop_run", "emergency_stop"})  # works whatever else does not


def executor_verbs(role: Role) -> frozenset[str]:
    """What a role may ask of an executor."""
    if role not in PEOPLE:
        return frozenset()
    return frozenset().union(*(_EXECUTOR_VERBS[each] for each in PEOPLE[: PEOPLE.index(role) + 1]))


def least_role(verb: str) -> Role:
    """The least role that may ask an executor for something; for what is not known, that of admins."""
    return next((role for role in PEOPLE if verb in _EXECUTOR_VERBS[role]), Role.ADMIN)
