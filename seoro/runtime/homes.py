"""Where actors live: which backend serves which actor, decided when a run is instantiated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import UnionType
from typing import Any, TypeAlias, TypeVar

from seoro.errors import ActionFailed, InvalidUse
from seoro.lang.frozen import Value
from seoro.runtime.capabilities import Connected
from seoro.runtime.contracts import Backend
from seoro.runtime.values import Actor

P = TypeVar("P")
Contract: TypeAlias = type[Any] | UnionType
"""A runtime-checkable protocol of what backends may be able to do, or a union of those of which one suffices."""


class Home(Value):
    """The place where one actor lives, and what it is called there."""

    backend: Backend
    name: str


class Placement(Value):
    """A home that was chosen for an actor from outside.

    Args:
        home: The home.
        kinds: The types of actors that it can stand for.
        place: Where it was chosen, for messages.
    """

    home: Home
    kinds: Sequence[str]
    place: str


class Homes:
    """All backends of a run, and the actors that were found to live in them.

    Args:
        backends: In the order in which they are asked.
        placements: Homes that were chosen, by the name of the actor; backends are not asked for these.
    """

    def __init__(self, backends: Sequence[Backend], placements: Mapping[str, Placement]) -> None:
        self.backends = tuple(backends)
        self._placements = dict(placements)
        self._homes: dict[str, Home] = {}

    def check(self) -> None:
        """Check, when all actors have settled, that there are all for whom a home was chosen.

        Raises:
            InvalidUse: There is none of that name.
        """
        for name, placement in self._placements.items():
            if name not in self._homes:
                raise InvalidUse(
                    f"{placement.place}: the scenario has no actor '{name}'",
                    help="a robot without a `type` has the name of its actor; with a `type`, runs choose it by "
                    f"`--set ACTOR=robot:{name}`",
                )

    def settle(self, actor: Actor) -> None:
        """Find the home of an actor; one that lives nowhere is a name only.

        Raises:
            InvalidUse: The home that was chosen cannot stand for the actor.
        """
        placement = self._placements.get(actor.name)
        if placement is not None:
            if actor.types[0] not in placement.kinds:
                raise InvalidUse(
                    f"{placement.place}: `{actor.name}` is of the type {actor.types[0]}, for which "
                    f"'{placement.home.name}' of {placement.home.backend.name} cannot stand",
                    help=f"it can stand for {', '.join(placement.kinds)}",
                )
            self._homes[actor.name] = placement.home
            return
        for backend in self.backends:
            name = backend.home_of(actor.name, actor.types)
            if name is not None:
                self._homes[actor.name] = Home(backend, name)
                return

    def of(self, actor: Actor) -> Home | None:
        """The home of an actor."""
        return self._homes.get(actor.name)

    def substitutions(self) -> dict[str, str]:
        """Names of homes by the actors that live in one of another name, without those that were placed."""
        return {
            name: home.name
            for name, home in self._homes.items()
            if home.name != name and name not in self._placements
        }

    def robots(self, names: Sequence[str]) -> tuple[Home, ...]:
        """The homes of actors that have some names; all homes if none is given.

        Raises:
            ActionFailed: No actor lives in a robot of such a name.
        """
        homes = list(dict.fromkeys(self._homes.values()))
        known = [home.name for home in homes]
        for name in names:
            if name not in known:
                raise ActionFailed(f"unknown robot '{name}' (robots of this run: {', '.join(known) or 'none'})")
        return tuple(home for home in homes if not names or home.name in names)

    def loss_since(self, moment: float) -> str:
        """Return why a backend may have missed something since a moment; empty if none can have.

        Args:
            moment: The moment, by `time.monotonic` [s].
        """
        connected = (each for each in self.backends if isinstance(each, Connected))
        return next(filter(None, (each.loss_since(moment) for each in connected)), "")

    def anywhere(self, contract: type[P]) -> P | None:
        """The first backend that serves a contract (a runtime-checkable protocol of `contracts`)."""
        return next((backend for backend in self.backends if isinstance(backend, contract)), None)

    def by_name(self, name: str, contract: type[P]) -> P | None:
        """The backend that serves a contract and in which an actor lives by that name, else the first."""
        called = (home.backend for home in self._homes.values() if home.name == name)
        return next((backend for backend in called if isinstance(backend, contract)), self.anywhere(contract))

    def serve(self, contract: Contract) -> bool:
        """Whether any backend serves a contract."""
        return any(isinstance(backend, contract) for backend in self.backends)
