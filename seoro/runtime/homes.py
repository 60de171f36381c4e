"""Where actors live: which backend serves which actor, decided when a run is instantiated."""

from __future__ import annotations

from collections.abc import Sequence
from types import UnionType
from typing import Any, TypeAlias, TypeVar

from seoro.lang.frozen import Value
from seoro.runtime.contracts import Backend
from seoro.runtime.values import Actor

P = TypeVar("P")
Contract: TypeAlias = type[Any] | UnionType
"""A runtime-checkable protocol of what backends may be able to do, or a union of those of which one suffices."""


class Home(Value):
    """The place where one actor lives, and what it is called there."""

    backend: Backend
    name: str


class Homes:
    """All backends of a run, and the actors that were found to live in them.

    Args:
        backends: In the order in which they are asked.
    """

    def __init__(self, backends: Sequence[Backend]) -> None:
        self.backends = tuple(backends)
        self._homes: dict[str, Home] = {}

    def settle(self, actor: Actor) -> None:
        """Find the home of an actor; one that lives nowhere is a name only."""
        for backend in self.backends:
            name = backend.home_of(actor.name, actor.types)
            if name is not None:
                self._homes[actor.name] = Home(backend, name)
                return

    def of(self, actor: Actor) -> Home | None:
        """The home of an actor."""
        return self._homes.get(actor.name)

    def anywhere(self, contract: type[P]) -> P | None:
        """The first backend that serves a contract (a runtime-checkable protocol of `contracts`)."""
        return next((backend for backend in self.backends if isinstance(backend, contract)), None)

    def serve(self, contract: Contract) -> bool:
        """Whether any backend serves a contract."""
        return any(isinstance(backend, contract) for backend in self.backends)
