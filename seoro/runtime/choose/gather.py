"""Collects what decides about an instance: its slots, those of all that it holds, and the constraints on them.

Types are gone through from the outside to the inside, since constraints outside may say what a slot inside holds:
one that has to be equal to another value is no new one. Constraints are then put into the order of 7.3.11.3.2, in
which those of inner instances come before those around them, and arguments and what is set from outside last.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from seoro.lang.plan import (
    ActorType,
    Compare,
    Constraint,
    ConstraintMember,
    Construct,
    Contains,
    Expression,
    FieldDeclaration,
    Latent,
    ListType,
    Literal,
    RangeType,
    RemoveDefault,
    StructType,
    Structure,
    StructureMember,
    Structures,
)
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import empty, scope_of
from seoro.runtime.choose.slots import Holder, Rule, Slot, Slots, slots_named
from seoro.runtime.environment import Environment, EvaluationError, NoChoice
from seoro.runtime.values import Actor, HasFields, Struct, Value

NESTED = 8  # instances of one type, each inside of the one before
INVOCATION = 1  # the depths, negated, of what stands around the instance
OVERRIDE = 2


@dataclass(frozen=True)
class Removal:
    """`remove_default` of a path."""

    order: tuple[int, int]
    environment: Environment
    parameter: Expression


class Gathering:
    """Slots and rules of one choice.

    Args:
        structures: The structures of all types.
    """

    def __init__(self, structures: Structures) -> None:
        self.slots = Slots()
        self.rules: list[Rule] = []
        self.latents: list[tuple[Slot, Latent]] = []
        self._structures = structures
        self._removals: list[Removal] = []
        self._queue: deque[Slot] = deque()
        self._within: dict[int, tuple[str, ...]] = {}  # by the identity of what is made here

    # ------------------------------------------------------------ the instance itself

    def add_root(
        self,
        structure: Structure,
        holder: HasFields,
        given: Mapping[str, Value],
        environment: Environment,
        level: int = 0,
    ) -> None:
        """Add the fields and constraints of the instance itself, or of a modifier of it at the level of that."""
        self._add_members(structure.members, holder, environment, -level, given)

    def add_value(self, slot: Slot, structure: Structure, given: Mapping[str, Value]) -> None:
        """Add a value that is made by itself: its fields, its constraints, and the subtypes that it may be of."""
        assert slot.made is not None
        slot.structure, slot.is_given = structure, False
        self.slots.add(slot)
        self._add_made(slot, structure, given)

    def add_constraints(self, members: Sequence[ConstraintMember], environment: Environment, level: int) -> None:
        """Add constraints from around the instance.

        Args:
            members: The constraints.
            environment: Their scope.
            level: `INVOCATION` or `OVERRIDE`.
        """
        for member in members:
            self._add_constraint(member, environment, -level)

    # ------------------------------------------------------------ members

    def _add_members(
        self,
        members: Sequence[StructureMember],
        holder: Struct | Actor | HasFields,
        environment: Environment,
        depth: int,
        given: Mapping[str, Value],
    ) -> None:
        for member in members:
            if isinstance(member, FieldDeclaration):
                self._add_field(member, holder, environment, depth, given)
            else:
                self._add_constraint(member, environment, depth)

    def _add_field(
        self,
        declared: FieldDeclaration,
        holder: Struct | Actor | HasFields,
        environment: Environment,
        depth: int,
        given: Mapping[str, Value],
    ) -> None:
        name = declared.span.text
        full = f"{environment.path}.{name}" if environment.path else name
        slot = Slot(full, declared.type, environment, holder, declared.name, depth + 1, declared.span)
        slot.within, slot.is_variable = self._within.get(id(holder), ()), declared.is_variable
        self._add_slot(slot)
        if declared.name in given:
            slot.is_given = True
            holder.fields[declared.name] = given[declared.name]  # type: ignore[index] # all holders have a dict
        elif declared.default is not None:
            rule = Rule(self._order(depth), environment, None, True, declared.default.span, slot, declared.default)
            self.rules.append(rule)

    def _add_slot(self, slot: Slot) -> None:
        self.slots.add(slot)
        self._queue.append(slot)

    def _add_constraint(self, member: ConstraintMember, environment: Environment, depth: int) -> None:
        order = self._order(depth)
        match member:
            case Constraint(condition, is_default, span):
                self.rules.append(Rule(order, environment, condition, is_default, span))
            case RemoveDefault(parameter):
                self._removals.append(Removal(order, environment, parameter))

    def _order(self, depth: int) -> tuple[int, int]:
        return -depth, len(self.rules) + len(self._removals)

    # ------------------------------------------------------------ expansion

    def expand(self) -> None:
        """Go on from the outside to the inside, until every slot is a cell, made here, given or defined."""
        while self._queue:
            slot = self._queue.popleft()
            if slot.is_given:
                continue
            match slot.type:
                case StructType() | ActorType():
                    self._expand_instance(slot, slot.type)
                case ListType() | RangeType():
                    slot.definition = self._definition(slot)
                    if slot.definition is None and isinstance(slot.type, RangeType):
                        self._expand_range(slot, slot.type)
                case _:
                    definition = self._definition(slot)
                    if slot.is_variable or (definition is not None and _is_no_number(definition.value)):
                        slot.definition = definition

    def _expand_instance(self, slot: Slot, type_: StructType | ActorType) -> None:
        definition = self._definition(slot)
        if definition is not None and not isinstance(definition.value, Construct):
            slot.definition = definition
            return
        arguments: tuple[tuple[str, Expression], ...] = ()
        if definition is not None:
            assert isinstance(definition.value, Construct)
            definition.is_done = True
            type_, arguments = definition.value.type, definition.value.arguments
        if slot.within.count(type_.name) >= NESTED:
            what = f"`{slot.path}` would hold instances of `{type_.name}` without end"
            hint = "say which one it is, such as `keep(a.other == b)`"
            raise NoChoice(what, "E0443", ((slot.span, "nothing says which one it is"),), hint)
        structure = slot.structure = self._structures.of(type_)
        made = slot.made = empty(structure, slot.path, Fields())
        self._within[id(made)] = (*slot.within, type_.name)
        slot.holder.fields[slot.key] = made  # type: ignore[index] # all holders have a dict
        self._add_made(slot, structure, {})
        for name, value in arguments:
            assert definition is not None
            part = self.slots.of(made)[name]
            rule = replace(definition, condition=None, subject=part, value=value, span=value.span, is_done=False)
            self.rules.append(rule)

    def _add_made(self, slot: Slot, structure: Structure, given: Mapping[str, Value]) -> None:
        made = slot.made
        assert made is not None
        inside = replace(scope_of(made, slot.environment), path=slot.path, bindings={})
        self._add_members(structure.members, made, inside, slot.depth, given)
        self.latents += [(slot, latent) for latent in structure.latents]

    def _expand_range(self, slot: Slot, type_: RangeType) -> None:
        self._add_parts(slot, ("lower", "upper"), type_)

    def size_list(self, slot: Slot, size: int) -> None:
        """Give a list that is made here its members."""
        assert isinstance(slot.type, ListType)
        self._add_parts(slot, tuple(str(position) for position in range(len(slot.parts), size)), slot.type)

    def _add_parts(self, slot: Slot, keys: tuple[str, ...], type_: ListType | RangeType) -> None:
        holder = next((part.holder for part in slot.parts.values()), Holder(Fields()))
        for key in keys:
            path = f"{slot.path}[{key}]" if isinstance(type_, ListType) else f"{slot.path}.{key}()"
            part = Slot(path, type_.element, slot.environment, holder, key, slot.depth + 1, slot.span)
            part.within = slot.within
            slot.parts[key] = part
            self._add_slot(part)

    def add_latent(self, slot: Slot, latent: Latent) -> None:
        """Add what a conditional subtype adds to a value that turned out to be of it."""
        made = slot.made
        assert made is not None
        made.latent.insert(0, latent.type)
        for member in latent.members:
            if isinstance(member, FieldDeclaration) and member.name in self.slots.of(made):
                reason = f"this is of two conditional types that both have a field `{member.name}`"
                raise EvaluationError(reason, slot.span)
        inside = replace(scope_of(made, slot.environment), path=slot.path, bindings={})
        self._add_members(latent.members, made, inside, slot.depth, {})

    # ------------------------------------------------------------ what overrides what

    def _definition(self, slot: Slot) -> Rule | None:
        """The equality that says what a slot holds, of those that are known by now; hard ones before defaults."""
        found = [rule for rule in self.rules if self._subject(rule) is slot and rule.value is not None]
        self._override(found, slot)
        active = sorted(
            (rule for rule in found if not rule.is_void), key=lambda rule: (rule.is_default, rule.order)
        )
        return active[0] if active else None

    def _override(self, rules: list[Rule], slot: Slot) -> None:
        """Void the defaults among equalities of a slot that others come after."""
        last = max((rule.order for rule in rules), default=None)
        removed = [self._removed_at(removal, slot) for removal in self._removals]
        for rule in rules:
            is_later = last is not None and rule.order < last
            is_removed = any(order is not None and rule.order < order for order in removed)
            rule.is_void = rule.is_void or (rule.is_default and (is_later or is_removed))

    def _removed_at(self, removal: Removal, slot: Slot) -> tuple[int, int] | None:
        found = self.slots.find(removal.parameter, removal.environment)
        return removal.order if found is slot else None

    def _subject(self, rule: Rule) -> Slot | None:
        """What a rule gives its value, or the range of it."""
        if rule.subject is None:
            match rule.condition:
                case Compare("==", left, right):
                    rule.subject = self.slots.find(left, rule.environment)
                    rule.value = right if rule.subject is not None else None
                case Contains(item):
                    rule.subject = self.slots.find(item, rule.environment)
                case _:
                    pass
        return rule.subject

    def settle_defaults(self) -> None:
        """Void every default that something after it overrides or removes (7.3.11.3.2)."""
        overriding: dict[int, tuple[int, int]] = {}  # by the slot
        for rule in self.rules:
            subject = self._subject(rule)
            if subject is not None:
                latest = overriding.get(id(subject))
                overriding[id(subject)] = max(latest, rule.order) if latest is not None else rule.order
        for removal in self._removals:
            found = self.slots.find(removal.parameter, removal.environment)
            if found is not None:
                latest = overriding.get(id(found))
                overriding[id(found)] = max(latest, removal.order) if latest is not None else removal.order
        for rule in self.rules:
            if rule.is_default and not rule.is_void:
                concerned = [rule.subject] if rule.subject is not None else []
                if rule.subject is None and rule.condition is not None:
                    concerned = slots_named(rule.condition, rule.environment, self.slots)
                rule.is_void = any(overriding.get(id(slot), rule.order) > rule.order for slot in concerned)


def _is_no_number(value: Expression | None) -> bool:
    """Whether a value is `nan`, to which nothing is equal."""
    return isinstance(value, Literal) and value.value != value.value
