"""Slots: places of an instance and its objects that get values when it is created.

Equalities, ranges and lists have no cells: their values are computed on access.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, cast

from seoro.lang import frozen, solve
from seoro.lang.arithmetic import UINT_LIMITS
from seoro.lang.plan import (
    Binding,
    EnumType,
    EnumValue,
    Expression,
    Field,
    Global,
    Index,
    ListType,
    Literal,
    Member,
    PhysicalType,
    PrimitiveType,
    Self,
    Size,
    Structure,
    ValueType,
    parts,
    walk,
)
from seoro.lang.source import Span
from seoro.runtime.values.environment import Deferred, Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Actor, Compute, Fields, HasFields, Range, Struct, Value

if TYPE_CHECKING:
    from seoro.lang.solve import Cell


class Holder(frozen.Value):
    """Holder of the members of a list or the bounds of a range while they are chosen."""

    fields: Fields


@dataclass(eq=False)
class Rule:
    """A constraint on an instance.

    Args:
        order: Later rules override earlier defaults: rules of inner instances come first, then by the text.
        environment: Its environment.
        condition: Its condition; None if the subject must equal the value.
        is_default: Whether it may be overridden.
        span: Its place.
        subject: The left side of an equality or of `in`.
        value: The right side of an equality, or None.
        is_void: Whether it was overridden or removed.
        is_done: Whether it defines its subject, and so holds.
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
        path: Its name in messages.
        type: Type of its values.
        environment: Environment of its holder.
        holder: Object with the slot as a field.
        key: Name of the field.
        depth: Number of surrounding instances.
        span: Its declaration.
        structure: Structure of its type, for structs and actors.
        within: Type names of the surrounding values.
        is_variable: Whether it is a variable, which takes its first value and is unconstrained.
        is_given: Whether its value is given.
        parts: Slots of the members of a constructed list, or of the bounds of a range.
        made: The constructed struct or actor.
        definition: Rule that defines its value, if it is neither constructed nor a cell.
        cell: Cell of its value in the solver.
        size: Cell of the size of a constructed list.
        is_sized: Whether the list has its size.
        limits: Minimum and maximum of its value, or of each part; None for those of the type.
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

    @property
    def instance(self) -> Struct | Actor:
        """The constructed struct or actor of a slot that has one."""
        assert self.made is not None
        return self.made

    @property
    def is_unsized(self) -> bool:
        """Whether it is a constructed list without a size yet."""
        is_constructed = isinstance(self.type, ListType) and not self.is_given and self.definition is None
        return is_constructed and not self.is_sized


class Slots:
    """All slots of a choice."""

    def __init__(self) -> None:
        self.all: list[Slot] = []
        self._by_holder: dict[int, dict[str, Slot]] = {}
        self._by_made: dict[int, Slot] = {}
        self._by_cell: dict[Cell, Slot] = {}
        self._holders: list[object] = []  # kept alive, so that their ids stay unique

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
        """Return the slots of an instance by field; empty for other objects."""
        return self._by_holder.get(id(holder), {})

    def make(self, slot: Slot, made: Struct | Actor) -> None:
        """Note the struct or actor constructed in a slot."""
        slot.made = made
        self._by_made[id(made)] = slot

    def stand_for(self, slot: Slot, cell: Cell) -> None:
        """Note the cell of a slot's value or size."""
        if isinstance(slot.type, ListType):
            slot.size = cell
        else:
            slot.cell = cell
        self._by_cell[cell] = slot

    def holding(self, made: object) -> Slot | None:
        """Return the slot of a constructed value."""
        return self._by_made.get(id(made))

    def with_cell(self, cell: Cell) -> Slot:
        """Return the slot of a cell."""
        return self._by_cell[cell]

    def find(self, expression: Expression, environment: Environment) -> Slot | None:
        """Return the slot of a path; None for other expressions and unknown slots."""
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
        """Return the slot of a known field of a slot's value."""
        slot = self.source(slot)
        if slot.made is not None:
            return self.of(slot.made).get(name)
        return self.of(slot.holder.fields[slot.key]).get(name) if slot.is_given else None

    def source(self, slot: Slot) -> Slot:
        """Return the slot that defines a slot, as far as definitions are known; often itself."""
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
    """Return the slots that an expression names."""
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
    """Return the slot of a constructed value outside of any field."""
    holder = Holder(Fields())
    holder.fields["value"] = made
    return Slot(environment.path or span.text, made.type, environment, holder, "value", 0, span, made=made)


def mentions(rules: Iterable[Rule], slots: Slots) -> tuple[dict[int, int], set[int]]:
    """Return the mentioned numbers of members of lists, and the lists with mentioned sizes, by identity."""
    least: dict[int, int] = {}
    sized: set[int] = set()
    for rule in rules:
        for current in walk(rule.condition) if rule.condition is not None else ():
            match current:
                case Index(items, Literal(int(position))):
                    slot = slots.find(items, rule.environment)
                    if slot is not None:
                        least[id(slot)] = max(least.get(id(slot), 0), position + 1)
                case Size(items):
                    slot = slots.find(items, rule.environment)
                    if slot is not None:
                        sized.add(id(slot))
                case _:
                    pass
    return least, sized


class Computation:
    """Computes values without cells.

    Args:
        slots: The slots of the choice.
        evaluate: Evaluates expressions.
    """

    def __init__(self, slots: Slots, evaluate: Evaluate) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._open: set[int] = set()  # slots being computed, by identity
        self.is_final = False  # whether all cells have their values, so that results are kept

    def of(self, holder: object) -> Compute:
        """Return the function that computes missing fields of an instance."""
        slots = self._slots.of(holder)

        def compute(name: str) -> Value:
            return self._value(slots[name])

        return compute

    def _value(self, slot: Slot) -> Value:
        """Return the value of a slot without a cell; kept once all cells are final."""
        if slot.definition is not None:
            value = self._defined(slot, slot.definition)
        elif "lower" in slot.parts:
            low, high = (part.holder.fields[part.key] for part in slot.parts.values())
            value = Range(cast(float, low), cast(float, high))
        elif isinstance(slot.type, ListType):
            value = tuple(part.holder.fields[part.key] for part in slot.parts.values())
        else:
            raise KeyError(slot.key)
        if self.is_final:
            assign(slot, value)
        return value

    def _defined(self, slot: Slot, definition: Rule) -> Value:
        assert definition.value is not None
        if id(slot) in self._open:
            raise EvaluationError(f"the value of `{slot.path}` depends on itself", slot.span)
        self._open.add(id(slot))
        try:
            return self._evaluate(definition.value, replace(definition.environment, path=slot.path))
        finally:
            self._open.remove(id(slot))


def assign(slot: Slot, value: Value) -> None:
    """Put a value into the instance that holds it."""
    slot.holder.fields[slot.key] = value  # type: ignore[index] # all holders have a dict


def domain_of(type_: ValueType) -> solve.Domain | None:
    """Return the domain of a scalar; None for other types."""
    match type_:
        case PrimitiveType("bool"):
            return solve.Boolean()
        case PrimitiveType("int"):
            return solve.Integer()
        case PrimitiveType("uint"):
            return solve.Integer(*UINT_LIMITS)
        case PrimitiveType("float") | PhysicalType():
            return solve.Real()
        case PrimitiveType():
            return solve.Free()
        case EnumType(name, members):
            by_number = {number: EnumValue(name, member, number) for member, number in reversed(members)}
            return solve.Choice(tuple(reversed(by_number.values())))
        case _:
            return None
