"""Roles of identities."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class Role(StrEnum):
    """Role of an identity. The order is part of serial numbers: append new roles."""

    VIEWER = "viewer"  # reads runs
    OPERATOR = "operator"  # submits and stops runs, emits events in them, moves robots
    ADMIN = "admin"  # sends every request
    EXECUTOR = "executor"  # runs scenarios, and sends their requests to nodes
    NODE = "node"  # a simulator, or a bridge to robots
    ROUTER = "router"  # forwards messages
    SITE = "site"  # a host of `seoro ui`; without rights among the others

    @property
    def listens(self) -> bool:
        """Whether others connect to it; people never listen, so their keys cannot pose as a machine."""
        return self in LISTENING

    def includes(self, other: Role) -> bool:
        """Whether the role has all rights of another."""
        return self is other or (self in PEOPLE and other in PEOPLE[: PEOPLE.index(self)])

    @property
    def number(self) -> int:
        """Index of the role in serial numbers."""
        return list(Role).index(self)


LISTENING: Final = frozenset({Role.EXECUTOR, Role.NODE, Role.ROUTER, Role.SITE})
NAMED: Final = frozenset({Role.EXECUTOR, Role.NODE})  # addressed by name
PEOPLE: Final = (Role.VIEWER, Role.OPERATOR, Role.ADMIN)  # each includes the rights of the previous ones

MOVING: Final = frozenset({Role.OPERATOR, Role.ADMIN, Role.EXECUTOR})  # may move simulated and real robots
