"""Subjects of rules: the slot on the left side of an equality or of `in`, or in `remove_default`.

They are found as soon as their slots exist.

Slots are created from the outside to the inside. A path through a slot without contents waits for that slot, so
that nothing is searched repeatedly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from seoro.lang.plan import Compare, Contains, Convert, Expression, Index, Literal, Member
from seoro.runtime.choose.slots import Rule, Slot, Slots
from seoro.runtime.values.environment import Environment


@dataclass(eq=False)
class Removal:
    """`remove_default` of a path; its subject is the slot of the path."""

    order: tuple[int, int]
    environment: Environment
    parameter: Expression
    subject: Slot | None = None


class Subjects:
    """Rules and removals by their subjects.

    Args:
        slots: The slots.
    """

    def __init__(self, slots: Slots) -> None:
        self._slots = slots
        self._new: list[Rule | Removal] = []
        self._waiting: dict[int, list[Rule | Removal]] = {}  # by identity of a slot without contents
        self._nowhere: list[Rule | Removal] = []  # with a missing first field
        self._rules: dict[int, list[Rule]] = {}  # by identity of the slot
        self._removals: dict[int, list[Removal]] = {}

    def add(self, about: Rule | Removal) -> None:
        """Add a rule or a removal; its subject is found when its instance has its fields."""
        self._new.append(about)

    def fill(self, slot: Slot) -> None:
        """Note that a slot has contents, and search the waiting paths again."""
        self._new += self._waiting.pop(id(slot), [])

    def add_fields(self) -> None:
        """Note that an object has new fields."""
        self._new += self._nowhere
        self._nowhere = []

    def equalities(self, slot: Slot) -> list[Rule]:
        """Return the known equalities of a slot."""
        self.find()
        return [rule for rule in self._rules.get(id(slot), []) if rule.value is not None]

    def removed(self, slot: Slot) -> tuple[int, int] | None:
        """Return the order of the last `remove_default` of a slot, or None."""
        self.find()
        return max((removal.order for removal in self._removals.get(id(slot), [])), default=None)

    def places(self) -> Iterator[tuple[Slot, tuple[int, int]]]:
        """Yield all known subjects with the order of their rules and removals."""
        self.find()
        for found in (self._rules, self._removals):
            for about in (each for every in found.values() for each in every):
                assert about.subject is not None
                yield about.subject, about.order

    def find(self) -> None:
        """Find the subjects that exist now."""
        for about in self._new:
            path = _path(about)
            if about.subject is None and path is not None:
                about.subject = self._slots.find(path, about.environment)
            if about.subject is None:
                if path is not None:
                    self._wait(about, path)
                continue
            if isinstance(about, Removal):
                self._removals.setdefault(id(about.subject), []).append(about)
                continue
            if isinstance(about.condition, Compare):
                about.value = about.condition.right
            self._rules.setdefault(id(about.subject), []).append(about)
        self._new = []

    def _wait(self, about: Rule | Removal, path: Expression) -> None:
        reached = self._reached(path, about.environment)
        if reached is None:
            self._nowhere.append(about)
        else:
            self._waiting.setdefault(id(reached), []).append(about)

    def _reached(self, path: Expression, environment: Environment) -> Slot | None:
        """Return the last existing slot on a path."""
        while isinstance(path, Member) or (isinstance(path, Index) and isinstance(path.position, Literal)):
            path = path.base if isinstance(path, Member) else path.items
            slot = self._slots.find(path, environment)
            if slot is not None:
                return self._slots.source(slot)
        return None


def _path(about: Rule | Removal) -> Expression | None:
    """Return the path to a subject, or None."""
    if isinstance(about, Removal):
        return about.parameter
    match about.condition:
        case Compare("==", left):
            return left
        case Contains(Convert(item)) | Contains(item):
            return item
        case _:
            return None
