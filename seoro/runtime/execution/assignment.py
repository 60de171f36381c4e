"""Assignment of actors to backends, decided when a run is instantiated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import UnionType
from typing import Any, TypeAlias, TypeVar

from seoro.errors import ActionFailed, UsageError
from seoro.lang.frozen import Value
from seoro.runtime.contracts.backends import Backend, Connected
from seoro.runtime.values.values import Actor

P = TypeVar("P")
Contract: TypeAlias = type[Any] | UnionType
"""A runtime-checkable protocol for backends, or a union of which one part is enough."""


class Home(Value):
    """Backend of an actor, and the actor's name there."""

    backend: Backend
    name: str


class Placement(Value):
    """A home chosen by the user for an actor.

    Args:
        home: The home.
        kinds: Types of actors that the robot can stand for; None for all.
        place: Place of the choice, for messages.
    """

    home: Home
    kinds: Sequence[str] | None
    place: str


class ActorAssignment:
    """The backends of a run, and the homes of its actors.

    Args:
        backends: The backends, in the order of search.
        placements: Homes chosen by the user, by actor name.
    """

    def __init__(self, backends: Sequence[Backend], placements: Mapping[str, Placement]) -> None:
        self.backends = tuple(backends)
        self._placements = dict(placements)
        self._homes: dict[str, Home] = {}

    def check(self) -> None:
        """Check, after the assignment of all actors, that every placement names an actor.

        Raises:
            UsageError: A placement names an unknown actor.
        """
        for name, placement in self._placements.items():
            if name not in self._homes:
                raise UsageError(
                    f"{placement.place}: unknown actor '{name}' in this scenario",
                    help="a robot without a `type` stands for the actor of its name; robots with a `type` are "
                    f"chosen by `--set ACTOR=robot:{name}`",
                )

    def assign(self, actor: Actor) -> None:
        """Find the home of an actor. An actor without a home is a name only.

        Actors in its fields, such as the arm of a mobile manipulator, are parts of the same robot.

        Raises:
            UsageError: The chosen robot cannot stand for the actor.
        """
        placement = self._placements.get(actor.name)
        if placement is not None:
            if placement.kinds is not None and actor.types[0] not in placement.kinds:
                raise UsageError(
                    f"{placement.place}: '{placement.home.name}' of {placement.home.backend.name} cannot stand "
                    f"for `{actor.name}` of the type {actor.types[0]}",
                    help=f"it can stand for {', '.join(placement.kinds)}",
                )
            self._settle(actor, placement.home)
            return
        for backend in self.backends:
            name = backend.assign_robot(actor.name, actor.types)
            if name is not None:
                self._settle(actor, Home(backend, name))
                return

    def _settle(self, actor: Actor, home: Home) -> None:
        """Give an actor and its parts a home."""
        self._homes[actor.name] = home
        for part in actor.fields.values():
            if isinstance(part, Actor):
                self._settle(part, home)

    def of(self, actor: Actor) -> Home | None:
        """Return the home of an actor, or None."""
        return self._homes.get(actor.name)

    def substitutions(self) -> dict[str, str]:
        """Return the robots of actors with another name, except for placements."""
        return {
            name: home.name
            for name, home in self._homes.items()
            if home.name != name and "." not in name and name not in self._placements
        }

    def robots(self, names: Sequence[str]) -> tuple[Home, ...]:
        """Return the homes with the given names; all homes if empty.

        Raises:
            ActionFailed: A robot is unknown.
        """
        homes = list(dict.fromkeys(self._homes.values()))
        known = [home.name for home in homes]
        for name in names:
            if name not in known:
                raise ActionFailed(f"unknown robot '{name}' (robots of this run: {', '.join(known) or 'none'})")
        return tuple(home for home in homes if not names or home.name in names)

    def loss_since(self, moment: float) -> str:
        """Return why a backend may have missed events since `moment`; empty if none can have.

        Args:
            moment: Time of `time.monotonic` [s].
        """
        connected = (each for each in self.backends if isinstance(each, Connected))
        return next(filter(None, (each.loss_since(moment) for each in connected)), "")

    def anywhere(self, contract: type[P]) -> P | None:
        """Return the first backend that supports a contract (a runtime-checkable protocol), or None."""
        return next((backend for backend in self.backends if isinstance(backend, contract)), None)

    def by_name(self, name: str, contract: type[P]) -> P | None:
        """Return the backend that supports a contract and has an actor of that name, otherwise the first."""
        called = (home.backend for home in self._homes.values() if home.name == name)
        return next((backend for backend in called if isinstance(backend, contract)), self.anywhere(contract))

    def serve(self, contract: Contract) -> bool:
        """Whether any backend supports a contract."""
        return any(isinstance(backend, contract) for backend in self.backends)
