"""Collects what decides about an instance: its slots, those of all that it holds, and the constraints on them.

Types are gone through from the outside to the inside, since constraints outside may say what a slot inside holds:
one that has to be equal to another value is no new one. Constraints are then put into the order of 7.3.11.3.2, in
which those of inner instances come before those around them. Arguments come after what their instance says
(7.3.5.1.3), and what is set from outside last.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from seoro.lang.plan import (
    ActorType,
    Constraint,
    ConstraintMember,
    Construct,
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
from seoro.runtime.applied import Applied, apply, with_nested
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import empty, scope_of
from seoro.runtime.choose.slots import Holder, Rule, Slot, Slots, slots_named
from seoro.runtime.choose.subjects import Removal, Subjects
from seoro.runtime.choose.times import OVERLAP, Times, kind_value
from seoro.runtime.environment import Calls, Environment, EvaluationError, NoChoice
from seoro.runtime.values import Actor, HasFields, Struct, Value

NESTED = 8  # instances of one type, each inside of the one before
INVOCATION = 1  # the depths, negated, of what stands around the instance
OVERRIDE = 2
OF_OBJECTS = -3  # the position of modifiers of what an instance holds, among what modifies it


class Gathering:
    """Slots and rules of one choice.

    Args:
        structures: The structures of all types.
    """

    def __init__(self, structures: Structures) -> None:
        self.slots = Slots()
        self.rules: list[Rule] = []
        self.latents: list[tuple[Slot, Latent]] = []
        self._arguments: list[tuple[Slot, tuple[int, int]]] = []  # with their places in the order
        self._structures = structures
        self._subjects = Subjects(self.slots)
        self._count = 0  # of rules and removals
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
        order = self._order(-level)
        self._arguments += [(slot, order) for name, slot in self.slots.of(holder).items() if name in given]

    def add_value(self, slot: Slot, structure: Structure, given: Mapping[str, Value]) -> None:
        """Add a value that is made by itself: its fields, its constraints, and the subtypes that it may be of."""
        assert slot.made is not None
        slot.structure, slot.is_given = structure, False
        self.slots.add(slot)
        self._add_made(slot, structure, given)

    def add_times(self, times: Times, holder: HasFields, environment: Environment) -> None:
        """Add the parameters that a behavior has for its times; what arguments say about them is apart."""
        given = {OVERLAP: kind_value(times.overlap)} if times.overlap and times.is_overlap_given else {}
        for declared, limits in times.declarations():
            self._add_field(declared, holder, environment, 0, given)
            self.slots.of(holder)[declared.name].limits = limits

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
            order, span = self._order(depth), declared.default.span
            self._add_rule(Rule(order, environment, None, True, span, slot, declared.default))

    def _add_slot(self, slot: Slot) -> None:
        self.slots.add(slot)
        self._queue.append(slot)

    def _add_constraint(self, member: ConstraintMember, environment: Environment, depth: int) -> None:
        order = self._order(depth)
        match member:
            case Constraint(condition, is_default, span):
                self._add_rule(Rule(order, environment, condition, is_default, span))
            case RemoveDefault(parameter):
                self._subjects.add(Removal(order, environment, parameter))

    def _add_rule(self, rule: Rule) -> None:
        self.rules.append(rule)
        self._subjects.add(rule)

    def _order(self, depth: int) -> tuple[int, int]:
        self._count += 1
        return -depth, self._count

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
                    self._subjects.fill(slot)
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
            self._subjects.fill(slot)
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
        made = empty(structure, slot.path, Fields())
        self.slots.make(slot, made)
        self._within[id(made)] = (*slot.within, type_.name)
        slot.holder.fields[slot.key] = made  # type: ignore[index] # all holders have a dict
        self._add_made(slot, structure, {})
        for name, value in arguments:
            assert definition is not None
            part = self.slots.of(made)[name]
            rule = replace(definition, condition=None, subject=part, value=value, span=value.span, is_done=False)
            self._add_rule(rule)

    def _add_made(self, slot: Slot, structure: Structure, given: Mapping[str, Value]) -> None:
        made = slot.made
        assert made is not None
        inside = replace(scope_of(made, slot.environment), path=slot.path, bindings={})
        self._add_members(structure.members, made, inside, slot.depth, given)
        self._add_modifiers(slot, inside)
        self._subjects.fill(slot)
        self.latents += [(slot, latent) for latent in structure.latents]

    def _add_modifiers(self, slot: Slot, inside: Environment) -> None:
        """Add the modifiers that are members of the types of a value, and that it has not been given yet."""
        made = slot.made
        assert made is not None
        present = {applied.plan.span for applied in made.modifiers}
        declared = self._structures.applied_to(made.types)
        new = [each for each in declared if each.span not in present]
        if not new:
            return
        self._count += 1
        modifying = apply(new, self._structures.modifiers, inside, made, (OF_OBJECTS, self._count))
        made.modifiers += tuple(each for each in modifying if isinstance(each, Applied))
        for applied in with_nested(modifying):
            attached = applied.attached(inside.calls or Calls())
            holder, environment = attached.environment.instance, attached.environment
            self._add_members(attached.structure.members, holder, environment, slot.depth, {})
            for constraint in attached.constraints:
                self._add_constraint(constraint, attached.around, slot.depth)

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
            part.within, part.limits = slot.within, slot.limits
            slot.parts[key] = part
            self._add_slot(part)
        self._subjects.fill(slot)

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
        self._add_modifiers(slot, inside)
        self._subjects.fill(slot)
        self._subjects.add_fields()

    def rules_of(self, slot: Slot, latent: Latent) -> Iterator[Rule]:
        """The hard constraints of a conditional subtype on a value that may turn out to be of it."""
        made = slot.made
        assert made is not None
        inside = replace(scope_of(made, slot.environment), path=slot.path, bindings={})
        for member in latent.members:
            if isinstance(member, Constraint) and not member.is_default:
                yield Rule(self._order(slot.depth), inside, member.condition, False, member.span)

    # ------------------------------------------------------------ what overrides what

    def _definition(self, slot: Slot) -> Rule | None:
        """The equality that says what a slot holds, of those that are known by now; hard ones before defaults."""
        found = self._subjects.equalities(slot)
        self._override(found, slot)
        active = [rule for rule in found if not rule.is_void and not self._leads_back(rule, slot)]
        return min(active, key=lambda rule: (rule.is_default, rule.order), default=None)

    def _leads_back(self, rule: Rule, slot: Slot) -> bool:
        """Whether what a slot is equal to has its value from the slot itself."""
        assert rule.value is not None
        other = self.slots.find(rule.value, rule.environment)
        return other is not None and self.slots.source(other) is slot

    def _override(self, rules: list[Rule], slot: Slot) -> None:
        """Void the defaults among equalities of a slot that others come after."""
        orders = [rule.order for rule in rules]
        removed = self._subjects.removed(slot)
        last = max([*orders, removed] if removed is not None else orders, default=None)
        for rule in rules:
            rule.is_void = rule.is_void or (rule.is_default and last is not None and rule.order < last)

    def settle_defaults(self) -> None:
        """Void every default that something after it overrides or removes (7.3.11.3.2)."""
        overriding: dict[int, tuple[int, int]] = {}  # by the slot
        for slot, order in (*self._subjects.places(), *self._arguments):
            overriding[id(slot)] = max(overriding.get(id(slot), order), order)
        for rule in self.rules:
            if rule.is_default and not rule.is_void:
                concerned = [rule.subject] if rule.subject is not None else []
                if rule.subject is None and rule.condition is not None:
                    concerned = slots_named(rule.condition, rule.environment, self.slots)
                rule.is_void = any(overriding.get(id(slot), rule.order) > rule.order for slot in concerned)


def _is_no_number(value: Expression | None) -> bool:
    """Whether a value is `nan`, to which nothing is equal."""
    return isinstance(value, Literal) and value.value != value.value
