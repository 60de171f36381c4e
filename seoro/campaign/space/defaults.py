"""Default values of axes: `noise: float = 0.1`, or `keep(default noise == 0.1)`, which comes first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.finding import constants_of, number_of, path_of
from seoro.lang.plan import Compare, Constraint, Expression, Plan
from seoro.runtime.values.environment import Environment


def find_defaults(plan: Plan, axes: Sequence[Axis]) -> Mapping[str, str]:
    """Find the default values of axes among the global parameters and those of the entry scenario.

    Args:
        plan: The plan.
        axes: The axes; defaults that they do not contain are left out.

    Returns:
        Values by path, in the notation of the scenario.
    """
    constants = constants_of(plan)
    by_path = {axis.path: axis for axis in axes}
    found: dict[str, str] = {}
    for path, value in (*_of_fields(plan), *_of_constraints(plan)):
        axis = by_path.get(path)
        text = _text(axis, value, constants) if axis is not None else None
        if text is not None:
            found[path] = text
    return found


def _of_fields(plan: Plan) -> Iterator[tuple[str, Expression]]:
    for structure in (plan.globals, plan.scenarios[plan.entry].structure):
        for field in structure.fields.values():
            if field.default is not None:
                yield field.name, field.default


def _of_constraints(plan: Plan) -> Iterator[tuple[str, Expression]]:
    for structure in (plan.globals, plan.scenarios[plan.entry].structure):
        for member in structure.members:
            match member:
                case Constraint(condition=Compare("==", left, right), is_default=True):
                    path = path_of(left, of_it=False)
                    if path is not None:
                        yield path, right


def _text(axis: Axis, value: Expression, constants: Environment) -> str | None:
    """Return a default in the notation of the scenario; None if the axis does not contain it."""
    number = number_of(value, constants)
    if isinstance(axis, Choices):
        if number is None or axis.numbers is None:
            return value.span.text if value.span.text in axis.texts else None
        return axis.texts[axis.numbers.index(number)] if number in axis.numbers else None
    return axis.text(number) if number is not None and axis.low <= number <= axis.high else None
