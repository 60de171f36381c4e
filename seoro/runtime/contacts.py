"""Contacts of robots during a run: who must not touch what, and what follows when it happens.

Backends report contacts with who moved into whom. Actions guard the robot that they move: what it strikes, unless
that is allowed, is their failure. Modifiers allow contacts for what they modify, and forbid them for all robots.
Where something applies is given by positions in the tree of invocations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from seoro.lang.frozen import Value
from seoro.runtime.capabilities import ContactSensing
from seoro.runtime.contracts import Backend, Contact
from seoro.runtime.homes import Home

Position = tuple[int, ...]
Names = frozenset[str] | None
"""Names of entities; None for all."""

EVENT = "contact"  # how backends call it


class Allowance(Value):
    """Contacts that are allowed while something is carried out.

    Args:
        position: Of what is carried out.
        home: The robot that may touch; None for all.
        entities: What may be touched.
    """

    position: Position
    home: Home | None
    entities: Names

    def covers(self, home: Home, other: str) -> bool:
        """Whether a robot may touch an entity by this."""
        return self.home in (None, home) and (self.entities is None or other in self.entities)


@dataclass(eq=False)
class _Watch:
    """Somebody who wants to know what robots strike."""

    position: Position
    homes: tuple[Home, ...]
    also_struck: bool
    is_of_block: bool  # whether what is allowed within counts, too
    found: Callable[[str], None]


class Contacts:
    """The contacts of a run.

    Args:
        warn: Writes a warning into the trace.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self._allowances: list[Allowance] = []
        self._watches: list[_Watch] = []
        self.unobserved: dict[
            str, None
        ] = {}  # robots that were moved and cannot be checked, as messages call them

    def tell(self, backend: Backend, arguments: Mapping[str, Any]) -> None:
        """A backend reports a contact."""
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

    @contextmanager
    def allow(self, position: Position, home: Home | None, entities: Names) -> Iterator[None]:
        """Allow contacts while the block lasts, for what is carried out at a position and below."""
        allowance = Allowance(position, home, entities)
        self._allowances.append(allowance)
        try:
            yield
        finally:
            # Equal ones are as good as each other.
            self._allowances.remove(allowance)

    @contextmanager
    def guard(
        self, position: Position, home: Home, entities: Names, found: Callable[[str], None]
    ) -> Iterator[None]:
        """Watch over a robot that is moved while the block lasts.

        Args:
            position: Of what moves it.
            home: The robot.
            entities: What it may touch.
            found: Called with the reason when it strikes something else.
        """
        if not senses(home):
            self._note_unobserved(home)
        watch = _Watch(position, (home,), also_struck=False, is_of_block=False, found=found)
        with self.allow(position, home, entities), self._watching(watch):
            yield

    @contextmanager
    def forbid(
        self, position: Position, homes: tuple[Home, ...], found: Callable[[str], None], *, also_struck: bool
    ) -> Iterator[None]:
        """Watch over robots while the block lasts; what is allowed around it and within it stays allowed.

        Args:
            position: Of the block.
            homes: The robots, whose contacts are sensed.
            found: Called with the reason when one strikes something.
            also_struck: Whether contacts count in which others struck the robot.
        """
        with self._watching(_Watch(position, homes, also_struck, is_of_block=True, found=found)):
            yield

    @contextmanager
    def _watching(self, watch: _Watch) -> Iterator[None]:
        self._watches.append(watch)
        try:
            yield
        finally:
            self._watches.remove(watch)

    def _note_unobserved(self, home: Home) -> None:
        called = f"{home.name} of {home.backend.name}"
        if called not in self.unobserved:
            self.unobserved[called] = None
            self._warn(f"contacts of {called} are unobserved: its actions do not fail when it touches something")


def senses(home: Home) -> bool:
    """Whether the contacts of a robot are reported."""
    return isinstance(home.backend, ContactSensing) and home.backend.senses_contacts(home.name)


def _is_within(position: Position, around: Position) -> bool:
    return position[: len(around)] == around


def _reason(contact: Contact, mine: str, other: str, robot: str, *, strikes: bool) -> str:
    own = robot if mine == robot else f"{robot}, which holds '{mine}',"
    what = f"{own} {'moved into' if strikes else 'was struck by'} '{other}'"
    where = "" if contact.position is None else " at ({:.3f}, {:.3f}, {:.3f}) m".format(*contact.position)
    return f"{what}{where}, {contact.time:.3f} s after the start; `allow_contact` of `osc.sim` allows contacts"
