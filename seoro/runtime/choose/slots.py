"""Slots: the places of an instance and of all that it holds which get values when it comes into being."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from seoro.lang.frozen import Value
from seoro.lang.plan import (
    Binding,
    Expression,
    Field,
    Global,
    Index,
    ListType,
    Literal,
    Member,
    Self,
    Structure,
    ValueType,
    parts,
)
from seoro.lang.source import Span
from seoro.runtime.choose.fields import Fields
from seoro.runtime.environment import Deferred, Environment
from seoro.runtime.values import Actor, HasFields, Struct

if TYPE_CHECKING:
    from seoro.lang.solve import Cell


class Holder(Value):
    """What has the members of a list, or the bounds of a range, while they are chosen."""

    fields: Fields


@dataclass(eq=False)
class Rule:
    """A constraint on an instance.

    Args:
        order: Later ones override defaults: those of inner instances come first, then by the text.
        environment: Its scope.
        condition: What has to be true; None if it is that the subject has the value.
        is_default: Whether it may be overridden.
        span: Its place.
        subject: What stands alone on the left side of an equality, or in front of `in`.
        value: What the subject has to be equal to; None if it is no equality.
        is_void: Whether it was overridden, or removed.
        is_done: Whether it has made its subject what it is, and holds by that.
    """

    order: tuple[int, int]
    environment: Environment
    condition: Expression | None
    is_default: bool
    span: Span
    subject: Slot | None = None
    value: Expression | None = None
    is_void: bool = False
    is_done: bool = False


@dataclass(eq=False)
class Slot:
    """A place that gets a value.

    Args:
        path: What people call it.
        type: The type of its values.
        environment: The scope of what has it.
        holder: What has it as a field.
        key: The name of the field.
        depth: How many instances it is inside of.
        span: Its declaration.
        structure: What it is made of, for structs and actors.
        within: Names of the types of the values that it is inside of.
        is_variable: Whether it is that of a variable, which takes its first value and is not constrained.
        is_given: Whether it has its value from the start.
        parts: What it consists of, if it is made here: the members of a list, or the bounds of a range.
        made: The struct or actor, if it is made here.
        definition: What gives its value, if that is neither made here nor a cell.
        cell: What stands for its value in the solver.
        size: What stands for the size of a list that is made here, until it has one.
        is_sized: Whether it has one.
        limits: The least and the greatest that its value, or each part of it, can be; None for those of the type.
    """

    path: str
    type: ValueType
    environment: Environment
    holder: Struct | Actor | Holder | HasFields
    key: str
    depth: int
    span: Span
    is_given: bool = False
    parts: dict[str, Slot] = field(default_factory=dict)
    made: Struct | Actor | None = None
    structure: Structure | None = None
    within: tuple[str, ...] = ()
    is_variable: bool = False
    definition: Rule | None = None
    cell: Cell | None = None
    size: Cell | None = None
    is_sized: bool = False
    limits: tuple[float, float] | None = None


class Slots:
    """All slots of a choice, found by their paths."""

    def __init__(self) -> None:
        self.all: list[Slot] = []
        self._by_holder: dict[int, dict[str, Slot]] = {}
        self._by_made: dict[int, Slot] = {}
        self._by_cell: dict[Cell, Slot] = {}
        self._holders: list[object] = []  # kept alive, so that their ids stay theirs

    def add(self, slot: Slot) -> None:
        """Add a slot."""
        self.all.append(slot)
        key = id(slot.holder)
        if key not in self._by_holder:
            self._by_holder[key] = {}
            self._holders.append(slot.holder)
        self._by_holder[key][slot.key] = slot
        if slot.made is not None:
            self.make(slot, slot.made)

    def of(self, holder: object) -> Mapping[str, Slot]:
        """The slots of an instance; none if it had its values before."""
        return self._by_holder.get(id(holder), {})

    def make(self, slot: Slot, made: Struct | Actor) -> None:
        """Note the struct or actor that is made in a slot."""
        slot.made = made
        self._by_made[id(made)] = slot

    def stand_for(self, slot: Slot, cell: Cell) -> None:
        """Note the cell that stands for the value of a slot, or for its size."""
        if isinstance(slot.type, ListType):
            slot.size = cell
        else:
            slot.cell = cell
        self._by_cell[cell] = slot

    def holding(self, made: object) -> Slot | None:
        """The slot in which a value is made."""
        return self._by_made.get(id(made))

    def with_cell(self, cell: Cell) -> Slot:
        """The slot that a cell stands for."""
        return self._by_cell[cell]

    def find(self, expression: Expression, environment: Environment) -> Slot | None:
        """The slot that a path leads to; None if it is no path, or leads to none."""
        match expression:
            case Field(name):
                return self.of(environment.instance).get(name)
            case Global(name):
                return self.of(environment.outermost).get(name)
            case Member(Self(), name):
                return self.of(environment.instance).get(name)
            case Binding(bound) if isinstance(value := environment.bindings.get(bound), Deferred):
                return self.find(value.expression, value.environment)
            case Member(Binding(bound) as base, name):
                value = environment.bindings.get(bound)
                if isinstance(value, Deferred):
                    return self.find(Member(value.expression, name, base.span), value.environment)
                return self.of(value).get(name)
            case Member(base, name):
                holder = self.find(base, environment)
                return self._part(holder, name) if holder is not None else None
            case Index(items, Literal(int(position))):
                holder = self.find(items, environment)
                return holder.parts.get(str(position)) if holder is not None else None
            case _:
                return None

    def _part(self, slot: Slot, name: str) -> Slot | None:
        """A field of what a slot holds, where that is known by now."""
        slot = self.source(slot)
        if slot.made is not None:
            return self.of(slot.made).get(name)
        return self.of(slot.holder.fields[slot.key]).get(name) if slot.is_given else None

    def source(self, slot: Slot) -> Slot:
        """The slot that gives a slot its value, by as many definitions as are known; often itself."""
        passed: set[int] = set()
        while (definition := slot.definition) is not None and id(slot) not in passed:
            passed.add(id(slot))
            assert definition.value is not None
            other = self.find(definition.value, definition.environment)
            if other is None:
                break
            slot = other
        return slot


def slots_named(expression: Expression, environment: Environment, slots: Slots) -> list[Slot]:
    """The slots that an expression names."""
    found: list[Slot] = []
    pending = [expression]
    while pending:
        current = pending.pop()
        slot = slots.find(current, environment)
        if slot is not None:
            found.append(slot)
        else:
            pending += parts(current)
    return found


def value_slot(made: Struct | Actor, environment: Environment, span: Span) -> Slot:
    """The slot of a value that is made by itself, and is no field of anything yet."""
    holder = Holder(Fields())
    holder.fields["value"] = made
    return Slot(environment.path or span.text, made.type, environment, holder, "value", 0, span, made=made)
