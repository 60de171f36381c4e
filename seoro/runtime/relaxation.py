"""Relaxation of an invocation: its parameters and constraints, reduced to those that are fixed by the text.

Constraints that read anything else, and defaults that it may override, are left out. If what remains cannot hold
together, no run can carry out the invocation.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import replace

from seoro.lang.plan import (
    Action,
    Binding,
    Call,
    Constraint,
    ConstraintMember,
    Construct,
    Expression,
    Field,
    FieldDeclaration,
    Global,
    Labelled,
    Member,
    Plan,
    Reference,
    RemoveDefault,
    Scenario,
    Self,
    Structure,
    StructureMember,
    Structures,
    parts,
)
from seoro.runtime.choose.domains import domain_of
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.times import DURATION
from seoro.runtime.environment import Environment, EvaluationError
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instances import Instance
from seoro.runtime.values import Value

_OPEN = (Binding, Call, Global, Labelled, Reference, Self)  # what they stand for is not fixed by the text


def within(expression: Expression) -> Iterator[Expression]:
    """Yield an expression and all in it."""
    yield expression
    for part in parts(expression):
        yield from within(part)


def is_fixed(expression: Expression, names: Set[str], structures: Structures) -> bool:
    """Whether the value of an expression follows from the text and from the fields with these names."""
    for each in within(expression):
        if isinstance(each, _OPEN) or (isinstance(each, Field) and each.name not in names):
            return False
        if isinstance(each, Construct):
            structure = structures.of(each.type)
            if not structure.is_plain or not structure.open_fields <= {name for name, _ in each.arguments}:
                return False
    return True


def fixed_values(
    expressions: Iterable[tuple[str, Expression]], known: Mapping[str, Value], around: Environment, plan: Plan
) -> dict[str, Value]:
    """Return the values of those expressions that are fixed.

    Args:
        expressions: Expressions by name.
        known: Fields of the instance in whose scope they stand.
        around: That scope.
        plan: The plan.
    """
    found: dict[str, Value] = {}
    for name, expression in expressions:
        if is_fixed(expression, known.keys(), plan.structures):
            try:
                found[name] = evaluate(expression, around)
            except EvaluationError:
                continue  # the run reports it
    return found


def scope_of(declared: Scenario | Action, known: Mapping[str, Value]) -> Environment:
    """The scope of an instance with some of its values."""
    fields = Fields()
    fields.update(known)
    return Environment(Instance(declared.name, fields, declared, {}))


def known_in(
    declared: Scenario,
    given: Mapping[str, Value],
    passed: Set[str],
    limits: tuple[ConstraintMember, ...],
    plan: Plan,
) -> dict[str, Value]:
    """Return the parameters of a scenario that are fixed: those that are given, and uncontested defaults.

    Args:
        declared: The scenario.
        given: Values of arguments that are fixed.
        passed: Names of all parameters that have arguments.
        limits: Constraints of the invocation.
        plan: The plan.
    """
    known = dict(given)
    contested = passed | {name for each in (*declared.structure.members, *limits) for name in _read(each)}
    for field in declared.structure.fields.values():
        if field.default is not None and not field.is_variable and field.name not in contested:
            known |= fixed_values([(field.name, field.default)], known, scope_of(declared, known), plan)
    return known


def _read(member: StructureMember) -> Iterator[str]:
    """Names of the fields that a constraint may be about."""
    if isinstance(member, FieldDeclaration):
        return
    for each in within(member.parameter if isinstance(member, RemoveDefault) else member.condition):
        if isinstance(each, Field) or (isinstance(each, Member) and isinstance(each.base, Binding | Self)):
            yield each.name


class Relaxation:
    """The parameters and constraints of an invocation that are fixed by the text.

    Args:
        structure: What is invoked.
        given: Values of arguments that are fixed.
        passed: Names of all parameters that have arguments.
        limits: Constraints of the invocation.
        known: Names of the fields of the invoking scenario that are fixed.
        plan: The plan.
    """

    def __init__(
        self,
        structure: Structure,
        given: Mapping[str, Value],
        passed: Set[str],
        limits: tuple[ConstraintMember, ...],
        known: Set[str],
        plan: Plan,
    ) -> None:
        self._given, self._known, self._plan = given, known, plan
        members = [each for each in structure.members if not isinstance(each, FieldDeclaration)]
        self._free: set[str] = set(passed - given.keys())
        self._fields = structure.fields
        self._settle((*members, *limits))
        kept = tuple(each for each in members if self._holds(each, is_inside=True))
        fields = tuple(self._relaxed(each) for each in self._fields.values())
        self.structure = replace(
            structure,
            fields={each.name: each for each in fields},
            members=(*fields, *kept),
            open_fields=frozenset(),
        )
        self.limits = tuple(each for each in limits if self._holds(each, is_inside=False))

    @property
    def is_bound(self) -> bool:
        """Whether any constraint remains."""
        return bool(self.limits) or not self.structure.is_plain

    def _settle(self, members: Iterable[ConstraintMember]) -> None:
        """Leave out fields without fixed values, and free those that constraints may change that are left out."""
        before = -1
        while len(self._free) > before:
            before = len(self._free)
            self._fields = {name: each for name, each in self._fields.items() if self._is_kept(each)}
            for each in members:
                if not (self._is_readable(each, is_inside=True) or self._is_readable(each, is_inside=False)):
                    self._free |= set(_read(each))

    def _is_kept(self, field: FieldDeclaration) -> bool:
        """Whether a field takes part: it has a fixed value, or is a parameter with a value that can be chosen."""
        if field.name in self._given:
            return True
        if field.is_variable or domain_of(field.type) is not None:
            return not field.is_variable
        return field.default is None and field.name not in self._free and not self._plan.globals.fields

    def _holds(self, member: ConstraintMember, *, is_inside: bool) -> bool:
        if isinstance(member, Constraint) and member.is_default and not self._free.isdisjoint(_read(member)):
            return False
        return self._is_readable(member, is_inside=is_inside)

    def _is_readable(self, member: ConstraintMember, *, is_inside: bool) -> bool:
        """Whether a constraint reads nothing but fields that take part.

        Args:
            member: The constraint.
            is_inside: Whether it is a constraint of what is invoked, not of the invocation.
        """
        expression = member.parameter if isinstance(member, RemoveDefault) else member.condition
        own = {*self._fields, DURATION}
        pending = [expression]
        while pending:
            each = pending.pop()
            match each:
                case Member(Binding("it"), name) if not is_inside and name in own:
                    continue
                case Field(name) if name not in (self._fields if is_inside else self._known):
                    return False
                case Construct():
                    return False
                case _ if isinstance(each, _OPEN):
                    return False
            pending += parts(each)
        return True

    def _relaxed(self, field: FieldDeclaration) -> FieldDeclaration:
        """A field, without a default that may not be its value."""
        default = field.default
        if default is None or field.name in self._given:
            return field
        if field.name in self._free or not is_fixed(default, self._fields.keys(), self._plan.structures):
            return replace(field, default=None)
        return field
