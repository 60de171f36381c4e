"""Axes of a sweep: parameters of the scenario and its invocations with a constraint `in [...]` on listed values.

`keep(noise in [0.0, 0.1])` makes `noise` an axis of two values. A sweep runs all combinations of the values of all
axes. Ranges, `in [0.0..0.7]`, are not axes: each run draws from them. Parameters with given values are not varied,
either.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod

from seoro.errors import UsageError
from seoro.lang.frozen import Value
from seoro.lang.lower.invocations import named_invocations
from seoro.lang.plan import Binding, Constraint, Contains, Expression, Field, ListOf, Member, Plan
from seoro.lang.source import Span

MAX_COMBINATIONS = 100_000


class Axis(Value):
    """Varied parameter.

    Args:
        path: Path: `noise`, `robot.noise`, `drive.speed` of the invocation `drive`.
        values: Values in the notation of the scenario.
        span: Place of the list in the text.
    """

    path: str
    values: tuple[str, ...]
    span: Span


def find_axes(plan: Plan, given: Collection[str]) -> tuple[Axis, ...]:
    """Find the axes of the entry scenario, in source order.

    Args:
        plan: The plan.
        given: Paths of parameters with given values.
    """
    found: dict[str, Axis] = {}
    scenario = plan.scenarios[plan.entry]
    for condition in _conditions(scenario.structure.members):
        _add(condition, _path(condition.item, of_it=False), given, found)
    for name, invocation in named_invocations(scenario.body).items():
        for condition in _conditions(invocation.constraints):
            path = _path(condition.item, of_it=True)
            _add(condition, f"{name}.{path}" if path is not None else None, given, found)
    return tuple(found.values())


def _conditions(members: Iterable[object]) -> Iterator[Contains]:
    for member in members:
        match member:
            case Constraint(condition=Contains(container=ListOf()) as condition, is_default=False):
                yield condition


def _add(condition: Contains, path: str | None, given: Collection[str], found: dict[str, Axis]) -> None:
    """Add an axis; several lists for one parameter are intersected."""
    assert isinstance(condition.container, ListOf)
    if path is None or _is_given(path, given):
        return
    values = dict.fromkeys(each.span.text for each in condition.container.items)
    if path in found:
        values = {text: None for text in found[path].values if text in values}
    found[path] = Axis(path, tuple(values), condition.container.span)


def combinations(axes: Sequence[Axis]) -> Iterator[Mapping[str, str]]:
    """Yield all combinations of the values of axes, by path; the last axis varies fastest.

    Raises:
        UsageError: There are too many combinations.
    """
    number = prod(len(axis.values) for axis in axes)
    if number > MAX_COMBINATIONS:
        raise UsageError(
            f"too many combinations: {number:,}, limit {MAX_COMBINATIONS:,}",
            help="give some parameters a value with `--set PATH=VALUE`",
        )
    for values in product(*(axis.values for axis in axes)):
        yield {axis.path: value for axis, value in zip(axes, values, strict=True)}


def _path(item: Expression, *, of_it: bool) -> str | None:
    """Return the path of a parameter of the scenario, or of `it` in a `with` block; None for other expressions."""
    match item:
        case Member(Binding("it"), name) if of_it:
            return name
        case Field(name) if not of_it:
            return name
        case Member(base, name):
            around = _path(base, of_it=of_it)
            return None if around is None else f"{around}.{name}"
        case _:
            return None


def _is_given(path: str, given: Collection[str]) -> bool:
    """Return whether a parameter, or a parent of it, has a given value."""
    return any(path == each or path.startswith(f"{each}.") for each in given)
