"""Collection of the slots of an instance and of its objects, and of the constraints on them.

Types are expanded from the outside to the inside, since outer constraints may define an inner slot: a slot that
equals another value needs no new one. Constraints are then sorted as in 7.3.11.3.2: those of inner instances come
first. Arguments come after the constraints of their instance (7.3.5.1.3), overrides by the user last.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from seoro.lang import plan as plan_
from seoro.runtime.choose.plain import empty, scope_of
from seoro.runtime.choose.slots import Holder, Rule, Slot, Slots, slots_named
from seoro.runtime.choose.subjects import Removal, Subjects
from seoro.runtime.instances.applied import Applied, apply, with_nested
from seoro.runtime.instances.times import OVERLAP, Times, kind_value
from seoro.runtime.values.environment import Calls, Environment, EvaluationError, NoSolution
from seoro.runtime.values.values import Actor, Fields, HasFields, Struct, Value

NESTED = 8  # nested instances of one type
INVOCATION = 1  # negated depth of constraints around the instance
OVERRIDE = 2
OF_OBJECTS = -3  # position of modifiers of held objects among the modifications


class Gathering:
    """Slots and rules of one choice.

    Args:
        plan: The plan.
    """

    def __init__(self, plan: plan_.Plan) -> None:
        self.slots = Slots()
        self.rules: list[Rule] = []
        self.latents: list[tuple[Slot, plan_.Latent]] = []
        self._arguments: list[tuple[Slot, tuple[int, int]]] = []  # with their places in the order
        self._plan = plan
        self._subjects = Subjects(self.slots)
        self._count = 0  # of rules and removals
        self._queue: deque[Slot] = deque()
        self._within: dict[int, tuple[str, ...]] = {}  # by the identity of the tree node

    # ------------------------------------------------------------ the instance itself

    def add_root(
        self,
        structure: plan_.Structure,
        holder: HasFields,
        given: Mapping[str, Value],
        environment: Environment,
        level: int = 0,
    ) -> None:
        """Add the fields and constraints of the instance, or of a modifier at its level."""
        self._add_members(structure.members, holder, environment, -level, given)
        order = self._order(-level)
        self._arguments += [(slot, order) for name, slot in self.slots.of(holder).items() if name in given]

    def add_value(self, slot: Slot, structure: plan_.Structure, given: Mapping[str, Value]) -> None:
        """Add a constructed value: its fields, constraints and possible subtypes."""
        assert slot.made is not None
        slot.structure, slot.is_given = structure, False
        self.slots.add(slot)
        self._add_made(slot, structure, given)

    def add_times(self, times: Times, holder: HasFields, environment: Environment) -> None:
        """Add the timing parameters of a behavior; arguments are added separately."""
        given = {OVERLAP: kind_value(times.overlap)} if times.overlap and times.is_overlap_given else {}
        for declared, limits in times.declarations():
            self._add_field(declared, holder, environment, 0, given)
            self.slots.of(holder)[declared.name].limits = limits

    def add_constraints(
        self, members: Sequence[plan_.ConstraintMember], environment: Environment, level: int
    ) -> None:
        """Add constraints from outside the instance.

        Args:
            members: The constraints.
            environment: Their environment.
            level: `INVOCATION` or `OVERRIDE`.
        """
        for member in members:
            self._add_constraint(member, environment, -level)

    # ------------------------------------------------------------ members

    def _add_members(
        self,
        members: Sequence[plan_.StructureMember],
        holder: Struct | Actor | HasFields,
        environment: Environment,
        depth: int,
        given: Mapping[str, Value],
    ) -> None:
        for member in members:
            if isinstance(member, plan_.FieldDeclaration):
                self._add_field(member, holder, environment, depth, given)
            else:
                self._add_constraint(member, environment, depth)

    def _add_field(
        self,
        declared: plan_.FieldDeclaration,
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

    def _add_constraint(self, member: plan_.ConstraintMember, environment: Environment, depth: int) -> None:
        order = self._order(depth)
        match member:
            case plan_.Constraint(condition, is_default, span):
                self._add_rule(Rule(order, environment, condition, is_default, span))
            case plan_.RemoveDefault(parameter):
                self._subjects.add(Removal(order, environment, parameter))

    def _add_rule(self, rule: Rule) -> None:
        self.rules.append(rule)
        self._subjects.add(rule)

    def _order(self, depth: int) -> tuple[int, int]:
        self._count += 1
        return -depth, self._count

    # ------------------------------------------------------------ expansion

    def expand(self) -> None:
        """Expand from the outside to the inside, until every slot is a cell, constructed, given or defined."""
        while self._queue:
            slot = self._queue.popleft()
            if slot.is_given:
                continue
            match slot.type:
                case plan_.StructType() | plan_.ActorType():
                    self._expand_instance(slot, slot.type)
                case plan_.ListType() | plan_.RangeType():
                    slot.definition = self._definition(slot)
                    self._subjects.fill(slot)
                    if slot.definition is None and isinstance(slot.type, plan_.RangeType):
                        self._add_parts(slot, ("lower", "upper"), slot.type)
                case _:
                    definition = self._definition(slot)
                    if slot.is_variable or (definition is not None and _is_no_number(definition.value)):
                        slot.definition = definition

    def _expand_instance(self, slot: Slot, type_: plan_.StructType | plan_.ActorType) -> None:
        definition = self._definition(slot)
        if definition is not None and not isinstance(definition.value, plan_.Construct):
            slot.definition = definition
            self._subjects.fill(slot)
            return
        arguments: tuple[tuple[str, plan_.Expression], ...] = ()
        if definition is not None:
            assert isinstance(definition.value, plan_.Construct)
            definition.is_done = True
            type_, arguments = definition.value.type, definition.value.arguments
        if slot.within.count(type_.name) >= NESTED:
            what = f"`{slot.path}` would hold endlessly nested instances of `{type_.name}`"
            hint = "define it by an equality, such as `keep(a.other == b)`"
            raise NoSolution(what, "E0443", ((slot.span, "no equality defines it"),), hint)
        structure = slot.structure = self._plan.structures.of(type_)
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

    def _add_made(self, slot: Slot, structure: plan_.Structure, given: Mapping[str, Value]) -> None:
        self._add_contents(slot, structure.members, given)
        self.latents += [(slot, latent) for latent in structure.latents]

    def _add_contents(
        self, slot: Slot, members: Sequence[plan_.StructureMember], given: Mapping[str, Value]
    ) -> None:
        """Add members and modifiers of a constructed value."""
        inside = _scope_of(slot)
        self._add_members(members, slot.instance, inside, slot.depth, given)
        self._add_modifiers(slot, inside)
        self._subjects.fill(slot)

    def _add_modifiers(self, slot: Slot, inside: Environment) -> None:
        """Add modifiers that are members of the types of a value, once each."""
        made = slot.instance
        present = {applied.plan.span for applied in made.modifiers}
        declared = self._plan.object_type(made.types)
        new = [each for each in declared.modifiers if each.span not in present] if declared is not None else []
        if not new:
            return
        self._count += 1
        modifying = apply(new, self._plan.modifiers, inside, made, (OF_OBJECTS, self._count))
        made.modifiers += tuple(each for each in modifying if isinstance(each, Applied))
        for applied in with_nested(modifying):
            attached = applied.attached(inside.calls or Calls())
            holder, environment = attached.environment.instance, attached.environment
            self._add_members(attached.structure.members, holder, environment, slot.depth, {})
            self.add_constraints(attached.constraints, attached.around, -slot.depth)

    def size_list(self, slot: Slot, size: int) -> None:
        """Add the members of a list."""
        assert isinstance(slot.type, plan_.ListType)
        self._add_parts(slot, tuple(str(position) for position in range(len(slot.parts), size)), slot.type)

    def _add_parts(self, slot: Slot, keys: tuple[str, ...], type_: plan_.ListType | plan_.RangeType) -> None:
        holder = next((part.holder for part in slot.parts.values()), Holder(Fields()))
        for key in keys:
            path = f"{slot.path}[{key}]" if isinstance(type_, plan_.ListType) else f"{slot.path}.{key}()"
            part = Slot(path, type_.element, slot.environment, holder, key, slot.depth + 1, slot.span)
            part.within, part.limits = slot.within, slot.limits
            slot.parts[key] = part
            self._add_slot(part)
        self._subjects.fill(slot)

    def add_latent(self, slot: Slot, latent: plan_.Latent) -> None:
        """Add the members of a conditional subtype to a value of that type."""
        made = slot.instance
        made.latent.insert(0, latent.type)
        for member in latent.members:
            if isinstance(member, plan_.FieldDeclaration) and member.name in self.slots.of(made):
                reason = f"this is of two conditional types that both have a field `{member.name}`"
                raise EvaluationError(reason, slot.span)
        self._add_contents(slot, latent.members, {})
        self._subjects.add_fields()

    def rules_of(self, slot: Slot, latent: plan_.Latent) -> Iterator[Rule]:
        """Yield the hard constraints of a possible conditional subtype."""
        inside = _scope_of(slot)
        for member in latent.members:
            if isinstance(member, plan_.Constraint) and not member.is_default:
                yield Rule(self._order(slot.depth), inside, member.condition, False, member.span)

    # ------------------------------------------------------------ what overrides what

    def _definition(self, slot: Slot) -> Rule | None:
        """Return the known equality that defines a slot; hard ones before defaults."""
        found = self._subjects.equalities(slot)
        self._override(found, slot)
        active = [rule for rule in found if not rule.is_void and not self._leads_back(rule, slot)]
        return min(active, key=lambda rule: (rule.is_default, rule.order), default=None)

    def _leads_back(self, rule: Rule, slot: Slot) -> bool:
        """Whether the definition of a slot depends on the slot itself."""
        assert rule.value is not None
        other = self.slots.find(rule.value, rule.environment)
        return other is not None and self.slots.source(other) is slot

    def _override(self, rules: list[Rule], slot: Slot) -> None:
        """Void the defaults of a slot that later equalities override."""
        orders = [rule.order for rule in rules]
        removed = self._subjects.removed(slot)
        last = max([*orders, removed] if removed is not None else orders, default=None)
        for rule in rules:
            rule.is_void = rule.is_void or (rule.is_default and last is not None and rule.order < last)

    def settle_defaults(self) -> None:
        """Void every default that is overridden or removed (7.3.11.3.2)."""
        overriding: dict[int, tuple[int, int]] = {}  # by the slot
        for slot, order in (*self._subjects.places(), *self._arguments):
            overriding[id(slot)] = max(overriding.get(id(slot), order), order)
        for rule in self.rules:
            if rule.is_default and not rule.is_void:
                concerned = [rule.subject] if rule.subject is not None else []
                if rule.subject is None and rule.condition is not None:
                    concerned = slots_named(rule.condition, rule.environment, self.slots)
                rule.is_void = any(overriding.get(id(slot), rule.order) > rule.order for slot in concerned)


def _scope_of(slot: Slot) -> Environment:
    """Return the environment of the members of the value in a slot."""
    return replace(scope_of(slot.instance, slot.environment), path=slot.path, bindings={})


def _is_no_number(value: plan_.Expression | None) -> bool:
    """Whether a value is `nan`, which equals nothing."""
    return isinstance(value, plan_.Literal) and value.value != value.value
