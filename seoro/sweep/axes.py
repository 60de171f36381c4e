"""What varies in a sweep: parameters with a constraint `in [...]` that lists values, of the scenario and of what
it invokes.

`keep(noise in [0.0, 0.1])` makes `noise` an axis of two values, and all combinations of the values of all axes
are what is swept. Ranges, `in [0.0..0.7]`, are no axes: each run draws from them. A parameter that is given from
outside does not vary either.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod

from seoro.errors import InvalidUse
from seoro.lang.frozen import Value
from seoro.lang.lower.invocations import named_invocations
from seoro.lang.plan import Binding, Constraint, Contains, Expression, Field, ListOf, Member, Plan
from seoro.lang.source import Span

MAX_COMBINATIONS = 100_000


class Axis(Value):
    """A parameter that varies.

    Args:
        path: The parameter: `noise`, `robot.noise`, `drive.speed` of the invocation `drive`.
        values: The values, each as the scenario writes it.
        span: The list in the text.
    """

    path: str
    values: tuple[str, ...]
    span: Span


def find_axes(plan: Plan, given: Collection[str]) -> tuple[Axis, ...]:
    """The axes of the entry scenario, in the order of the text.

    Args:
        plan: The plan.
        given: Paths of parameters that have values from outside.
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
    """Add an axis; of several lists for one parameter, what they have in common."""
    assert isinstance(condition.container, ListOf)
    if path is None or _is_given(path, given):
        return
    values = dict.fromkeys(each.span.text for each in condition.container.items)
    if path in found:
        values = {text: None for text in found[path].values if text in values}
    found[path] = Axis(path, tuple(values), condition.container.span)


def combinations(axes: Sequence[Axis]) -> Iterator[Mapping[str, str]]:
    """All combinations of the values of axes, by path; the last axis varies fastest.

    Raises:
        InvalidUse: There are too many.
    """
    number = prod(len(axis.values) for axis in axes)
    if number > MAX_COMBINATIONS:
        raise InvalidUse(
            f"there are {number:,} combinations, and at most {MAX_COMBINATIONS:,} can be run",
            help="give some parameters a value with `--set PATH=VALUE`",
        )
    for values in product(*(axis.values for axis in axes)):
        yield {axis.path: value for axis, value in zip(axes, values, strict=True)}


def _path(item: Expression, *, of_it: bool) -> str | None:
    """The path of a parameter of the scenario, or of `it` in a `with` block; None if it is anything else."""
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
    """Whether a parameter, or something that holds it, has a value from outside."""
    return any(path == each or path.startswith(f"{each}.") for each in given)
