"""Time limits of behaviors that cannot be met: they are shorter than the fixed waiting times within."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.tree import find
from seoro.lang.units import to_si

_LASTING: Final = frozenset(
    {
        "timeout", "repeat", "retry", "inverter", "failure_is_success", "success_is_failure", "failure_is_running",
        "success_is_running",
    }
)  # modifiers that never end a behavior early with success  # fmt: skip
_REPEAT: Final = "repeat"


def too_short(checked: Checked, body: ast.DoBody) -> Iterator[Diagnostic]:
    """Yield warnings about the `timeout`, the `duration` and the constraints of a behavior."""
    least = _composed_time(checked, body) if isinstance(body, ast.Composition) else 0.0
    for modifier in _modifiers(body):
        yield from _timeout(checked, modifier, least)
    if isinstance(body, ast.Composition):
        yield from _duration(checked, body)
    modifications = _modifications(body)
    for member in modifications.members if modifications is not None else ():
        match member:
            case ast.KeepConstraint(_, ast.Relation("<" | "<=", left, right)) if _is_duration(left):
                limit = _seconds(checked, right)
                if limit is not None and limit < least:
                    yield messages.impossible_duration(member.span, limit, least)
            case _:
                pass


def expiring(checked: Checked, modifier: ast.FunctionApplication, body: ast.DoBody) -> Iterator[Diagnostic]:
    """Yield a warning about a `timeout` that a scenario has for its whole behavior."""
    yield from _timeout(checked, modifier, _least_time(checked, body))


def _timeout(checked: Checked, modifier: ast.FunctionApplication, needed: float) -> Iterator[Diagnostic]:
    limit = _seconds(checked, _first(modifier)) if _name(modifier) == "timeout" else None
    if limit is not None and limit < needed:
        yield messages.impossible_timeout(modifier.span, limit, needed)


def _duration(checked: Checked, body: ast.Composition) -> Iterator[Diagnostic]:
    """Yield a warning about the argument `duration` of a composition."""
    given = _given_duration(body)
    limit = _seconds(checked, given.high if isinstance(given, ast.RangeConstructor) else given)
    needed = _composed_time(checked, body)
    if given is not None and limit is not None and limit < needed:
        yield messages.impossible_duration(given.span, limit, needed)


def _given_duration(body: ast.Composition) -> ast.Expression | None:
    named = body.arguments.named if body.arguments is not None else ()
    return next((each.value for each in named if each.name.text == "duration"), None)


def _is_duration(node: ast.Expression) -> bool:
    return "".join(node.span.text.split()) == "it.duration"


def _least_time(checked: Checked, body: ast.DoBody) -> float:
    """Return the sum of the fixed waiting times [s] of a behavior; 0 if it may end early."""
    match body:
        case ast.WaitDirective(event=ast.ElapsedExpression(duration)):
            low = duration.low if isinstance(duration, ast.RangeConstructor) else duration
            return _seconds(checked, low) or 0.0
        case ast.Composition():
            return _composed_time(checked, body) * _repeats(body) if _lasts(body) else 0.0
        case _:
            return 0.0


def _composed_time(checked: Checked, body: ast.Composition) -> float:
    """Return the least time [s] of one execution of the members; 0 if they may end early."""
    if next(find(body, ast.EmitDirective), None) is not None:  # it may end the scenario
        return 0.0
    times = [_least_time(checked, member.body) for member in body.members]
    if body.operator == "serial":
        return sum(times)
    return max(times, default=0.0) if body.operator == "parallel" and body.arguments is None else 0.0


def _lasts(body: ast.Composition) -> bool:
    """Return whether a composition ends only with its members."""
    modifications = body.modifications
    if modifications is not None and next(find(modifications, ast.UntilDirective), None) is not None:
        return False
    return _given_duration(body) is None and all(_name(each) in _LASTING for each in _modifiers(body))


def _repeats(body: ast.Composition) -> int:
    """Return how often `repeat` executes a composition; once without a number."""
    counts = [_first(each) for each in _modifiers(body) if _name(each) == _REPEAT]
    numbers = [each.value for each in counts if isinstance(each, ast.IntegerLiteral)]
    return max(1, *numbers) if numbers else 1


def _modifications(body: ast.DoBody) -> ast.WithBlock | None:
    return body.modifications if isinstance(body, ast.Composition | ast.BehaviorInvocation) else None


def _modifiers(body: ast.DoBody) -> Iterator[ast.FunctionApplication]:
    modifications = _modifications(body)
    for member in modifications.members if modifications is not None else ():
        if isinstance(member, ast.ModifierApplication):
            yield member.invocation


def _name(invocation: ast.FunctionApplication) -> str:
    function = invocation.function
    return function.name.text if isinstance(function, ast.NameExpression) else ""


def _first(invocation: ast.FunctionApplication) -> ast.Expression | None:
    """Return the first argument of a modifier with one parameter."""
    arguments = invocation.arguments
    return next(iter((*arguments.positional, *(named.value for named in arguments.named))), None)


def _seconds(checked: Checked, node: ast.Expression | None) -> float | None:
    """Return the value of a literal in SI units; None for other expressions."""
    if not isinstance(node, ast.PhysicalLiteral):
        return None
    unit = checked.program.units.get(node.unit.text)
    return float(to_si(node.value, unit.factor, unit.offset)) if unit is not None else None
