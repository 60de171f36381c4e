"""Behaviors of the entry file that never run, or always fail."""

from __future__ import annotations

from collections.abc import Iterator, Set
from itertools import pairwise
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.symbols import TypeSymbol
from seoro.lang.tree import find, walk
from seoro.lang.units import to_si

_ENDS: Final = frozenset({"end", "fail"})
_VARIABLE = (
    ast.NameExpression | ast.EnumValueReference | ast.It | ast.FunctionApplication
)  # parts of conditions that depend on something
_WITH_CONDITION = ast.BoolCondition | ast.RiseExpression | ast.FallExpression


def suspicious_members(
    checked: Checked, scenario: TypeSymbol, members: tuple[ast.TypeMember, ...], emitted: Set[str]
) -> Iterator[Diagnostic]:
    """Yield warnings about the behavior and the reactions of a scenario.

    Args:
        checked: The checked file.
        scenario: The scenario.
        members: Members that the entry file declares.
        emitted: Names of events that files of the user emit.
    """
    for member in members:
        match member:
            case ast.DoDirective(body):
                yield from _behavior(checked, scenario, body, emitted)
            case ast.OnDirective(event):
                yield from _event(checked, scenario, event, emitted)
            case ast.EventDeclaration(_, _, specification) if specification is not None:
                yield from _event(checked, scenario, specification, emitted)
            case ast.KeepConstraint(_, constraint):
                yield from _constant(constraint)
            case _:
                pass


def _behavior(
    checked: Checked, scenario: TypeSymbol, root: ast.DoMember, emitted: Set[str]
) -> Iterator[Diagnostic]:
    pending = [root]
    while pending:
        body = pending.pop().body
        modifications: ast.WithBlock | None = None
        match body:
            case ast.Composition(operator, _, members, modifications):
                pending += members
                if operator == "serial":
                    yield from _after_end(members)
            case ast.BehaviorInvocation(_, modifications):
                pass
            case ast.WaitDirective(event):
                yield from _event(checked, scenario, event, emitted)
            case _:
                pass
        for member in modifications.members if modifications is not None else ():
            match member:
                case ast.UntilDirective(event):
                    yield from _event(checked, scenario, event, emitted)
                case ast.ModifierApplication(invocation):
                    yield from _timeout(checked, invocation, body)
                case ast.KeepConstraint(_, constraint):
                    yield from _constant(constraint)
                case _:
                    pass


def _after_end(members: tuple[ast.DoMember, ...]) -> Iterator[Diagnostic]:
    for member, following in pairwise(members):
        match member.body:
            case ast.EmitDirective(event) if event.namespace is None and event.text in _ENDS:
                yield messages.unreachable(following.span, event.text)
                return
            case _:
                pass


def _event(
    checked: Checked, scenario: TypeSymbol, event: ast.EventSpecification, emitted: Set[str]
) -> Iterator[Diagnostic]:
    condition = event.condition if isinstance(event, ast.EventOccurrence) else event
    if isinstance(condition, _WITH_CONDITION):
        yield from _constant(condition.condition)
    match event:
        case ast.EventOccurrence(path=ast.NameExpression(name)):
            users = {module.file for module in checked.sources.modules if module.library is None}
            for found in scenario.inventory.events.values():
                is_own = found.text == name.text and found.span.file in users and found.specification is None
                if is_own and name.text not in emitted:
                    yield messages.never_emitted(event.span, name.text)
        case _:
            pass


def _constant(condition: ast.Expression) -> Iterator[Diagnostic]:
    if not any(isinstance(part, _VARIABLE) for part in walk(condition)):
        yield messages.constant_condition(condition.span)


def _timeout(checked: Checked, invocation: ast.FunctionApplication, body: ast.DoBody) -> Iterator[Diagnostic]:
    """Compare the `timeout` of a behavior with the least time that it takes."""
    match invocation.function:
        case ast.NameExpression(name) if name.text == "timeout":
            arguments = invocation.arguments
            values = (*arguments.positional, *(named.value for named in arguments.named))
            limit = _seconds(checked, values[0]) if values else None
            if limit is not None and limit < (needed := _least_time(checked, body)):
                yield messages.impossible_timeout(invocation.span, limit, needed)
        case _:
            pass


def _least_time(checked: Checked, body: ast.DoBody) -> float:
    """Return the sum of the fixed waiting times [s] of a behavior; 0 if it may end early."""
    match body:
        case ast.WaitDirective(event=ast.ElapsedExpression(duration)):
            return _seconds(checked, duration) or 0.0
        case ast.Composition("serial", _, members, modifications):
            emits = next(find(body, ast.EmitDirective), None) is not None
            stops = modifications is not None and next(find(modifications, ast.UntilDirective), None) is not None
            ends_early = emits or stops
            return 0.0 if ends_early else sum(_least_time(checked, member.body) for member in members)
        case _:
            return 0.0


def _seconds(checked: Checked, node: ast.Expression) -> float | None:
    """Return the value of a literal in SI units; None for other expressions."""
    if not isinstance(node, ast.PhysicalLiteral):
        return None
    unit = checked.program.units.get(node.unit.text)
    return float(to_si(node.value, unit.factor, unit.offset)) if unit is not None else None
