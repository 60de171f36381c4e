"""Constructs whose traces no rule decides yet: one of them leaves a whole trace unchecked, and is named."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import assert_never

from seoro.lang.plan import (
    Behavior,
    Binding,
    CallMethod,
    Constraint,
    ConstraintMember,
    Emit,
    Expression,
    FieldDeclaration,
    InvokeAction,
    InvokeScenario,
    Member,
    Modifier,
    OneOf,
    OnEvent,
    Parallel,
    Phase,
    PhaseEvent,
    Plan,
    Serial,
    Wait,
    modifier_type,
    parts,
)
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule

_TIMES = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


def skip_beyond(plan: Plan, findings: Findings) -> bool:
    """Note what a plan has that is beyond the rules; whether there is anything."""
    found = [*_of_modifiers(plan), *_of_times(plan), *_of_ends(plan)]
    for rule, reason, span in found:
        findings.skip(rule, reason, span)
    return bool(found)


def _of_modifiers(plan: Plan) -> Iterator[tuple[Rule, str, Span]]:
    for name, modifier in plan.modifiers.items():
        if modifier.on or modifier.samples or plan.coverage.get(modifier_type(name)):
            yield Rule.MODIFIER, "what modifiers do at events is not decided", modifier.span
    for type_ in plan.objects.values():
        for applied in type_.modifiers:
            yield Rule.MODIFIER, "what modifiers of structs and actors do is not decided", applied.span


def _of_ends(plan: Plan) -> Iterator[tuple[Rule, str, Span]]:
    directives = [on for scenario in plan.scenarios.values() for on in scenario.on]
    directives += [on for action in plan.actions.values() for on in action.on]
    for directive in directives:
        match directive.event:
            case OnEvent(PhaseEvent(None, Phase.END | Phase.FAIL)):
                yield Rule.ON, "what reacts to an end that comes from around it is not decided", directive.span
            case _:
                pass


def _of_times(plan: Plan) -> Iterator[tuple[Rule, str, Span]]:
    reason = "what constraints on times of `it` mean is not decided"
    for modifier in plan.modifiers.values():
        for expression in _expressions(modifier):
            yield from ((Rule.DURATION, reason, part.span) for part in _times_in(expression))
    stack = [scenario.body for scenario in plan.scenarios.values() if scenario.body is not None]
    while stack:
        behavior = stack.pop()
        members, constraints = _inside(behavior)
        stack += members
        for constraint in constraints:
            if isinstance(constraint, Constraint):
                yield from ((Rule.DURATION, reason, part.span) for part in _times_in(constraint.condition))


def _inside(behavior: Behavior) -> tuple[tuple[Behavior, ...], tuple[ConstraintMember, ...]]:
    """The members of a behavior, and its constraints."""
    match behavior:
        case Serial() | Parallel() | OneOf():
            return behavior.members, behavior.constraints
        case InvokeAction() | InvokeScenario():
            return (), behavior.constraints
        case Wait() | Emit() | CallMethod():
            return (), ()
        case _:
            assert_never(behavior)


def _expressions(modifier: Modifier) -> Iterable[Expression]:
    for member in modifier.structure.members:
        if isinstance(member, Constraint):
            yield member.condition
        elif isinstance(member, FieldDeclaration) and member.default is not None:
            yield member.default


def _times_in(expression: Expression) -> Iterator[Member]:
    """The times of `it` in an expression."""
    pending = [expression]
    while pending:
        part = pending.pop()
        if isinstance(part, Member) and part.name in _TIMES and part.base == Binding("it", part.base.span):
            yield part
        pending += parts(part)
