"""Contacts of robots during a run: which are forbidden, and their consequences.

Backends report contacts with the striking entity. Actions guard the robot that they move: striking an entity fails
the action, unless the contact is allowed. Modifiers allow contacts within the behavior that they modify, and
forbid them for all robots. Scopes are positions in the tree of invocations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from typing import Any, TypeVar

from seoro.deferred import dataclass
from seoro.lang.frozen import Value
from seoro.runtime.contracts.backends import Backend
from seoro.runtime.contracts.contacts import Contact, ContactSensing
from seoro.runtime.execution.assignment import Home

T = TypeVar("T")
Position = tuple[int, ...]
Names = frozenset[str] | None
"""Names of entities; None for all."""


class Allowance(Value):
    """Contacts that are allowed during a behavior.

    Args:
        position: Position of the behavior.
        home: The robot; None for all.
        entities: Entities that it may touch.
    """

    position: Position
    home: Home | None
    entities: Names

    def covers(self, home: Home, other: str) -> bool:
        """Whether it allows a robot to touch an entity."""
        return self.home in (None, home) and (self.entities is None or other in self.entities)


@dataclass(eq=False)
class _Watch:
    """Observer of contacts of robots."""

    position: Position
    homes: tuple[Home, ...]
    also_struck: bool
    is_of_block: bool  # whether allowances within its position count too
    found: Callable[[str], None]


class Contacts:
    """The contacts of a run.

    Args:
        unobserved: Moved robots whose contacts are not reported, as named in messages; extended here.
        warn: Logs a warning in the trace.
    """

    def __init__(self, unobserved: dict[str, None], warn: Callable[[str], None]) -> None:
        self._unobserved = unobserved
        self._warn = warn
        self._allowances: list[Allowance] = []
        self._watches: list[_Watch] = []

    def report(self, backend: Backend, arguments: Mapping[str, Any]) -> None:
        """Handle a contact reported by a backend."""
        contact = Contact.of(arguments)
        for watch in tuple(self._watches):
            for home in watch.homes:
                if home.backend is backend and (reason := self._forbidden(watch, home, contact)):
                    watch.found(reason)
                    break

    def _forbidden(self, watch: _Watch, home: Home, contact: Contact) -> str:
        """Return the reason why a contact is forbidden by a watch; empty if it is allowed."""
        mine, other = contact.sides(home.name)
        if other is None or contact.held.get(other) == home.name:
            return ""
        strikes = contact.is_struck_by(home.name)
        if not (strikes or watch.also_struck) or self._is_allowed(watch, home, other):
            return ""
        return _reason(contact, mine, other, home.name, strikes=strikes)

    def _is_allowed(self, watch: _Watch, home: Home, other: str) -> bool:
        return any(
            allowance.covers(home, other)
            and (
                _is_within(watch.position, allowance.position)
                or (watch.is_of_block and _is_within(allowance.position, watch.position))
            )
            for allowance in self._allowances
        )

    def allow(self, position: Position, home: Home | None, entities: Names) -> AbstractContextManager[None]:
        """Allow contacts during the block, for behaviors at or below a position."""
        return _listed(self._allowances, Allowance(position, home, entities))

    @contextmanager
    def guard(
        self, position: Position, home: Home, entities: Names, found: Callable[[str], None]
    ) -> Iterator[None]:
        """Watch a moved robot during the block.

        Args:
            position: Position of the action that moves it.
            home: The robot.
            entities: Entities that it may touch.
            found: Called with the reason when it strikes another entity.
        """
        if not senses(home):
            self._note_unobserved(home)
        watch = _Watch(position, (home,), also_struck=False, is_of_block=False, found=found)
        with self.allow(position, home, entities), _listed(self._watches, watch):
            yield

    def forbid(
        self, position: Position, homes: tuple[Home, ...], found: Callable[[str], None], *, also_struck: bool
    ) -> AbstractContextManager[None]:
        """Watch robots during the block; contacts allowed around or within it stay allowed.

        Args:
            position: Position of the block.
            homes: The robots.
            found: Called with the reason when a robot strikes an entity.
            also_struck: Whether to count contacts in which the robot was struck.
        """
        return _listed(self._watches, _Watch(position, homes, also_struck, is_of_block=True, found=found))

    def _note_unobserved(self, home: Home) -> None:
        called = f"{home.name} of {home.backend.name}"
        if called not in self._unobserved:
            self._unobserved[called] = None
            self._warn(f"contacts of {called} are not reported: its actions do not fail on contacts")


def senses(home: Home) -> bool:
    """Whether the contacts of a robot are reported."""
    return isinstance(home.backend, ContactSensing) and home.backend.senses_contacts(home.name)


@contextmanager
def _listed(items: list[T], item: T) -> Iterator[None]:
    """Keep an item in a list during the block."""
    items.append(item)
    try:
        yield
    finally:
        items.remove(item)  # or an equal one


def _is_within(position: Position, around: Position) -> bool:
    return position[: len(around)] == around


def _reason(contact: Contact, mine: str, other: str, robot: str, *, strikes: bool) -> str:
    own = robot if mine == robot else f"{robot}, which holds '{mine}',"
    what = f"{own} {'moved into' if strikes else 'was struck by'} '{other}'"
    where = "" if contact.position is None else " at ({:.3f}, {:.3f}, {:.3f}) m".format(*contact.position)
    return f"{what}{where}, {contact.time:.3f} s after the start; `allow_contact` of `osc.sim` allows contacts"
