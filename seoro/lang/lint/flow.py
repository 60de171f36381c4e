"""Behaviors of the entry file that never run, or always fail."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from itertools import pairwise
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.lint.durations import expiring, too_short
from seoro.lang.symbols import TypeSymbol
from seoro.lang.tree import walk

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
            case ast.ModifierApplication(invocation):
                for each in members:
                    if isinstance(each, ast.DoDirective):
                        yield from expiring(checked, invocation, each.member.body)
            case _:
                pass


def _behavior(
    checked: Checked, scenario: TypeSymbol, root: ast.DoMember, emitted: Set[str]
) -> Iterator[Diagnostic]:
    pending = [root]
    while pending:
        body = pending.pop().body
        modifications: ast.WithBlock | None = None
        yield from too_short(checked, body)
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
    parts = list(walk(condition))
    if not any(isinstance(part, _VARIABLE) for part in parts) or _compares_with_itself(condition, parts):
        yield messages.constant_condition(condition.span)
    elif isinstance(condition, ast.Logic):
        for part in (condition.left, condition.right):
            yield from _constant(part)


def _compares_with_itself(condition: ast.Expression, parts: Sequence[ast.Node]) -> bool:
    if not isinstance(condition, ast.Relation) or any(isinstance(each, ast.FunctionApplication) for each in parts):
        return False
    left, right = ("".join(each.span.text.split()) for each in (condition.left, condition.right))
    return left == right
