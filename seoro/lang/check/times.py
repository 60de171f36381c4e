"""Arguments about time: of compositions, and `duration` of invocations (7.3.13, 7.6.2.4)."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Final, NamedTuple

from seoro.lang import ast, plan
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import DURATION, END_TO_END, OVERLAP, START_TO_START, TIME, Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors
from seoro.lang.members import MemberTable
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, RangeOf

_PARALLEL_ONLY: Final = (OVERLAP, START_TO_START, END_TO_END)
_Overlap = plan.Overlap
_STARTS: Final = {
    _Overlap.EQUAL: (0.0, 0.0),
    _Overlap.START: (0.0, 0.0),
    _Overlap.INITIAL: (-inf, 0.0),
    _Overlap.INSIDE: (0.0, inf),
    _Overlap.FULL: (-inf, 0.0),
}  # offsets of starts that kinds of overlap allow (table in 7.3.13.2)
_ENDS: Final = {
    _Overlap.EQUAL: (0.0, 0.0),
    _Overlap.END: (0.0, 0.0),
    _Overlap.FINAL: (0.0, inf),
    _Overlap.INSIDE: (-inf, 0.0),
    _Overlap.FULL: (0.0, inf),
}  # offsets of ends that they allow


def check_sign(time: plan.Expression, what: str, bag: Bag, is_positive: bool = False) -> None:
    """Report a literal time below zero, or zero if it must be positive."""
    for bound in _bounds(time):
        if bound.number < 0 or (is_positive and bound.number == 0):
            bag.add(behaviors.negative_time, bound.span, what, is_positive)


class _Bound(NamedTuple):
    """A literal bound."""

    number: float
    span: Span


def _bounds(time: plan.Expression) -> list[_Bound]:
    """Return the literal bounds of a range of times."""
    found = (time.low, time.high) if isinstance(time, plan.RangeOf) else (time,)
    return [
        _Bound(bound.value, bound.span)
        for bound in found
        if isinstance(bound, plan.Literal) and isinstance(bound.value, float)
    ]


class Times(NamedTuple):
    """Elaborated arguments about the starts and ends of members."""

    duration: plan.Expression | None
    overlap: plan.Overlap
    is_overlap_given: bool
    start_to_start: plan.Expression | None
    end_to_end: plan.Expression | None


class Timing:
    """Elaborates arguments about time in the behavior of one scenario.

    Args:
        expressions: The expression checker.
        scope: Scope of the arguments.
    """

    def __init__(self, expressions: Expressions, scope: Scope) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._scope = scope

    def of_composition(self, node: ast.Composition) -> Times:
        """Elaborate the arguments of a composition, whose parameters have no namespace (7.3.13)."""
        order = (*_PARALLEL_ONLY, DURATION) if node.operator == "parallel" else (DURATION,)
        given = self._bind(node.operator, order, node.arguments)
        overlap = self._overlap(given[OVERLAP]) if OVERLAP in given else None
        times = {name: self._range(name, value) for name, value in given.items() if name != OVERLAP}
        starts, ends = times.get(START_TO_START), times.get(END_TO_END)
        if overlap is not None:
            self._check_offset(overlap, START_TO_START, starts, _STARTS)
            self._check_offset(overlap, END_TO_END, ends, _ENDS)
        default = _Overlap.START if starts is None else _Overlap.ANY
        return Times(times.get(DURATION), overlap or default, overlap is not None, starts, ends)

    def of_invocation(
        self, arguments: ast.ArgumentList, parameters: MemberTable[FieldSymbol]
    ) -> tuple[plan.Expression | None, ast.ArgumentList]:
        """Return the implicit `duration` of an invocation, and the other arguments."""
        own: list[ast.NamedArgument] = []
        others: list[ast.NamedArgument] = []
        for argument in arguments.named:
            is_declared = self._expressions.lookup.parameter(self._scope.space, parameters, argument.name)
            is_own = argument.name.text == DURATION and argument.name.namespace is None and not is_declared
            (own if is_own else others).append(argument)
        if not own:
            return None, arguments
        given = self._bind(DURATION, (DURATION,), ast.ArgumentList((), tuple(own), arguments.span))
        rest = ast.ArgumentList(arguments.positional, tuple(others), arguments.span)
        return self._range(DURATION, given[DURATION]), rest

    def _bind(
        self, operator: str, order: tuple[str, ...], arguments: ast.ArgumentList | None
    ) -> dict[str, ast.Expression]:
        """Bind arguments to parameters, positional ones in order."""
        given: dict[str, ast.Expression] = {}
        places: dict[str, Span] = {}
        if arguments is None:
            return given
        for name, value in zip(order, arguments.positional, strict=False):
            given[name], places[name] = value, value.span
        for value in arguments.positional[len(order) :]:
            self._bag.add(behaviors.too_many_arguments, value.span, operator, len(order))
        for argument in arguments.named:
            name = argument.name.text
            if argument.name.namespace is not None or name not in order:
                self._report_unknown(operator, order, argument.name)
                continue
            if name in given:
                self._bag.add(behaviors.duplicate_argument, argument.name.span, name, places[name])
            given[name], places[name] = argument.value, argument.name.span
        return given

    def _report_unknown(self, operator: str, order: tuple[str, ...], name: ast.Name) -> None:
        if name.namespace is None and name.text in _PARALLEL_ONLY:
            self._bag.add(behaviors.parallel_only, name.span, name.text, operator)
        else:
            self._bag.add(behaviors.unknown_argument, name.span, operator, name.span.text, order)

    def _overlap(self, node: ast.Expression) -> plan.Overlap | None:
        """Read a kind of overlap, whose names are part of the language."""
        kinds = {kind.value: kind for kind in _Overlap}
        if isinstance(node, ast.NameExpression) and node.name.namespace is None and node.name.text in kinds:
            return kinds[node.name.text]
        self._bag.add(behaviors.unknown_overlap, node.span, tuple(kinds))
        return None

    def _range(self, name: str, node: ast.Expression) -> plan.Expression:
        """Elaborate a range of times; a single time is the range from and to itself."""
        found = self._expressions.converted(node, RangeOf(TIME), self._scope, f"`{name}`")
        if name == DURATION:
            check_sign(found, "duration", self._bag)
        return found

    def _check_offset(
        self,
        overlap: plan.Overlap,
        name: str,
        offset: plan.Expression | None,
        allowed: Mapping[plan.Overlap, tuple[float, float]],
    ) -> None:
        """Report a literal offset that the kind of overlap excludes."""
        numbers = [bound.number for bound in _bounds(offset)] if offset is not None else []
        low, high = allowed.get(overlap, (-inf, inf))
        if offset is not None and len(numbers) == 2 and (max(numbers) < low or min(numbers) > high):
            self._bag.add(behaviors.contradictory_offset, offset.span, name, overlap.value, low, high)
