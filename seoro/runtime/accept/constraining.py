"""Values of parameters: of their types, as arguments say, and such that all constraints hold (7.6.2.2, 7.6.2.3).

Whether a default is overridden is not decided here (7.3.11.3.2): one that does not hold is told as not checked.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import cast

from seoro.lang.plan import (
    Constraint,
    FieldDeclaration,
    InvokeAction,
    InvokeScenario,
    Modifier,
    ModifierApplication,
    Plan,
    Scenario,
    Structure,
    StructureMember,
    modifier_type,
)
from seoro.lang.source import Span
from seoro.runtime.accept.about_times import times_in
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.fitting import fits, same
from seoro.runtime.accept.frames import Matched
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import Actor, HasFields, Range, Struct, Value, plain


@dataclass(frozen=True, eq=False)
class _Applied:
    """A modifier as an instance with fields."""

    types: tuple[str, ...]
    fields: dict[str, Value]


@dataclass(eq=False)
class Constraining:
    """Checks values of parameters.

    Args:
        plan: The plan.
        history: The trace.
        world: Its values.
        findings: Gets what is wrong.
    """

    plan: Plan
    history: History
    world: World
    findings: Findings

    def check(self, matched: Matched) -> None:
        """Check all of them."""
        for plan, instance, around in matched.invocations:
            self._instance(instance)
            if plan is None:
                self._entry(instance)
            else:
                self._invoked(plan, instance, around)
        if matched.invocations:
            entry = matched.invocations[0][1]
            for holder, seq in self.world.told:
                self._object(holder, entry, seq)
        of_objects = [id(each) for type_ in self.plan.objects.values() for each in type_.modifiers]
        for application, modifier, node, environment in matched.modifiers:
            if id(application) in of_objects:
                reason = "the trace does not tell of which struct or actor it is, with which values"
                self.findings.skip(Rule.VALUE, reason, application.span)
            else:
                self._modifier(application, modifier, node, environment)

    # -------------------------------------------------------- instances

    def _instance(self, instance: Instance) -> None:
        """The values of an instance are of their types, and meet the constraints of its declaration."""
        structure = instance.declaration.structure
        place = instance.seq + 1
        if isinstance(instance.declaration, Scenario):
            self._types(structure, instance.fields, instance.seq)
        self._constraints(structure.members, instance.environment, place, instance.seq)

    def _entry(self, entry: Instance) -> None:
        """The values of the run are those that its start tells, and meet what was set from outside."""
        self._types(self.plan.globals, entry.fields, entry.seq)
        members: tuple[StructureMember, ...] = (*self.plan.globals.members, *self.plan.overrides)
        self._constraints(members, entry.environment, entry.seq + 1, entry.seq)
        told = self.history.run["parameters"]
        self.world.present.seq = entry.seq + 1
        values = {name: plain(value) for name, value in entry.fields.items()}
        for name in sorted(told.keys() | values.keys()):
            if name not in told or name not in values or not _alike(told[name], values[name]):
                message = f"`{name}` has another value at the start of the run than in the instance"
                self.findings.violate(Rule.VALUE, message, entry.declaration.span, 0, entry.seq)

    def _invoked(self, plan: InvokeScenario | InvokeAction, instance: Instance, around: Instance) -> None:
        """An invocation gives arguments and constraints."""
        outside, seq = around.environment, instance.seq
        for name, expression in plan.arguments:
            self._equal(name, expression, outside, instance, seq)
        inside = replace(outside, bindings={**outside.bindings, "it": instance})
        self._constraints(plan.constraints, inside, seq + 1, seq)
        given = {name for name, _ in plan.arguments}
        structure = instance.declaration.structure
        if structure.is_plain and not plan.constraints and not plan.modifications:
            for declared in structure.fields.values():
                if declared.name not in given and declared.default is not None:
                    self._equal(declared.name, declared.default, instance.environment, instance, seq)

    def _equal(
        self, name: str, expression: object, environment: Environment, instance: Instance, seq: int
    ) -> None:
        """A field has the value of an expression."""
        span = expression.span  # type: ignore[attr-defined] # all expressions have one
        try:
            expected = self.world.value(expression, environment, seq)  # type: ignore[arg-type]
        except Undecided as why:
            self.findings.skip(Rule.VALUE, why, span)
            return
        self.world.present.seq = seq
        if name not in instance.fields or not same(instance.fields[name], expected):
            told = plain(instance.fields[name]) if name in instance.fields else "no value"
            message = f"`{name}` has the value {told!r}, and should have {plain(expected)!r}"
            self.findings.violate(Rule.VALUE, message, span, seq)

    # -------------------------------------------------------- structs, actors, modifiers

    def _object(self, holder: Struct | Actor, entry: Instance, seq: int) -> None:
        """The fields of a struct or an actor are of their types, and meet its constraints."""
        structure = self.plan.structures.of(holder.type)
        environment = Environment(holder, {}, scenario=entry)
        self._types(structure, holder.fields, seq)
        self._constraints(structure.members, environment, seq + 1, seq)
        for latent in structure.latents:
            if latent.type in holder.latent:
                self._constraints(latent.members, environment, seq + 1, seq)

    def _modifier(
        self, application: ModifierApplication, modifier: Modifier, node: Node, around: Environment
    ) -> None:
        """The parameters of a modifier are what is given to it, and its constraints hold."""
        try:
            fields = {name: self.world.decode(value) for name, value in node.arguments.items()}
        except Undecided as why:
            self.findings.skip(Rule.VALUE, why, application.span)
            return
        self._types(modifier.structure, fields, node.start.seq)
        owner = node
        while owner.type == "modifier" and owner.parent is not None:
            owner = owner.parent
        place = owner.told[0] + 1 if owner.told else owner.start.seq
        bindings = {name: value for name, value in around.bindings.items() if name == "it"}
        try:
            for name, expression in application.arguments:
                if not same(fields[name], self.world.value(expression, around, place)):
                    message = f"`{name}` has not the value that is given to the modifier"
                    self.findings.violate(Rule.VALUE, message, expression.span, node.start.seq)
            for name, expression in application.ranges:
                bounds = self.world.value(expression, around, place)
                if isinstance(bounds, Range) and fields[name] not in bounds:
                    message = f"`{name}` is not in the range that is given to the modifier"
                    self.findings.violate(Rule.VALUE, message, expression.span, node.start.seq)
            if application.actor is not None:
                bindings["actor"] = self.world.value(application.actor, around, place)
        except (Undecided, KeyError) as why:
            self.findings.skip(Rule.VALUE, why, application.span)
            return
        holder = cast(HasFields, _Applied((modifier_type(modifier.name),), fields))
        inside = Environment(holder, bindings, scenario=around.outermost)
        self._constraints(modifier.structure.members, inside, place, node.start.seq)

    # -------------------------------------------------------- rules

    def _types(self, structure: Structure, fields: dict[str, Value], seq: int) -> None:
        for name, declared in structure.fields.items():
            if name not in fields:
                self.findings.violate(Rule.VALUE, f"`{name}` has no value", declared.span, seq)
            elif not fits(dict.__getitem__(fields, name), declared.type):
                message = f"`{name}` has the value {plain(dict.__getitem__(fields, name))!r}, not of its type"
                self.findings.violate(Rule.VALUE, message, declared.span, seq)

    def _constraints(
        self, members: Iterable[StructureMember], environment: Environment, place: int, seq: int
    ) -> None:
        """Hard constraints hold; defaults do unless they are overridden."""
        for member in members:
            match member:
                case Constraint(condition) if times_in(condition):
                    pass  # what it leaves of them is checked where the behavior runs
                case Constraint(condition, is_default, span):
                    self._constraint(condition, span, environment, place, seq, is_default=is_default)
                case FieldDeclaration():
                    pass
                case _:
                    pass  # `remove_default` is about defaults

    def _constraint(
        self,
        condition: object,
        span: Span,
        environment: Environment,
        place: int,
        seq: int,
        *,
        is_default: bool,
    ) -> None:
        try:
            holds = self.world.value(condition, environment, place)  # type: ignore[arg-type] # an expression
        except Undecided as why:
            self.findings.skip(Rule.CONSTRAINT, why, span)
            return
        if holds:
            return
        if is_default:
            self.findings.skip(Rule.CONSTRAINT, "whether this default is overridden is not decided", span)
        else:
            message = f"`{' '.join(span.text.split())}` does not hold for the values of the trace"
            self.findings.violate(Rule.CONSTRAINT, message, span, seq)


def _alike(told: object, value: object) -> bool:
    """Whether a value of the trace is a given one."""
    return _finite(told) == _finite(value)


def _finite(value: object) -> object:
    """A value as files have it, where floats that are not finite are texts."""
    match value:
        case float() if not math.isfinite(value):
            return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
        case list():
            return [_finite(item) for item in value]
        case dict():
            return {name: _finite(item) for name, item in value.items()}
        case _:
            return value
