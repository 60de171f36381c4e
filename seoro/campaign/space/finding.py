"""Finding of the axes of a scenario: parameters with a constraint `in` on listed values or on a range.

`keep(noise in [0.0, 0.1])` makes `noise` an axis of two values, `keep(gap in [0.4m..0.9m])` makes `gap` an axis
with bounds. Parameters with given values are not varied.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from itertools import compress
from typing import Final

from seoro.campaign.space.axes import Axis, Choices, Interval
from seoro.errors import UsageError
from seoro.lang import plan as plan_
from seoro.lang.lower.invocations import invoked_name, named_invocations
from seoro.lang.lower.outside import ORIGIN
from seoro.lang.plan import Binding, Constraint, Contains, Expression, Field, Global, ListOf, Member, Plan, RangeOf
from seoro.lang.source import Span
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Composed
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Fields

_NAME: Final = re.compile(r"[\w.?]+")  # of a parameter, or of a key of a world


def check_varied(varied: Collection[str]) -> None:
    """Check that texts are constraints, not only names.

    Raises:
        UsageError: A text is the name of a parameter.
    """
    for text in varied:
        if _NAME.fullmatch(name := text.strip()):
            raise UsageError(
                f"missing values for `{name}`, which shall vary",
                help=f"write `{name} in [LOW..HIGH]` or `{name} in [A, B]`; parameters with a range in the "
                "scenario vary without it",
            )


def find_axes(plan: Plan, given: Collection[str], varied: Collection[str] = ()) -> tuple[Axis, ...]:
    """Find the axes of the entry scenario, in source order.

    Args:
        plan: The plan.
        given: Paths of parameters with given values.
        varied: Constraints from outside that must make a parameter vary.

    Raises:
        UsageError: Constraints leave no value of a parameter, or one of `varied` makes none vary.
    """
    finding = _Finding(plan, given)
    axes = finding.axes()
    made = {span.file.text for span in finding.used if span.file.name == ORIGIN}
    for text in varied:
        if text not in made:
            raise UsageError(
                f"`{text}` makes no parameter vary",
                help="write `PARAMETER in [1mps..2mps]` or `PARAMETER in [1mps, 2mps]`, with constant values, for "
                "a parameter that is not set",
            )
    return axes


class _Finding:
    def __init__(self, plan: Plan, given: Collection[str]) -> None:
        self._plan = plan
        self._given = given
        self._found: dict[str, Axis] = {}
        self._constants = constants_of(plan)
        self.used: list[Span] = []  # conditions that make axes

    def axes(self) -> tuple[Axis, ...]:
        scenario = self._plan.scenarios[self._plan.entry]
        roots = (self._plan.globals, scenario.structure)
        fields = {name: field.type for root in roots for name, field in root.fields.items()}
        members = (*self._plan.globals.members, *scenario.structure.members, *self._plan.overrides)
        for condition in _conditions(members):
            self._add(condition, path_of(condition.item, of_it=False), fields)
        for name, invocation in named_invocations(scenario.body).items():
            of_it = {key: field.type for key, field in self._invoked(invocation).fields.items()}
            for condition in _conditions(invocation.constraints):
                path = path_of(condition.item, of_it=True)
                if condition.span.file.name == ORIGIN:
                    _check_argument(f"{name}.{path}", path, invocation)
                self._add(condition, path, of_it, f"{name}.")
        return tuple(self._found.values())

    def _invoked(self, invocation: plan_.InvokeAction | plan_.InvokeScenario) -> plan_.Structure:
        name = invoked_name(invocation)
        declared = self._plan.actions if isinstance(invocation, plan_.InvokeAction) else self._plan.scenarios
        return declared[name].structure

    def _add(
        self, condition: Contains, path: str | None, fields: dict[str, plan_.ValueType], prefix: str = ""
    ) -> None:
        """Add an axis; several constraints of one parameter are intersected."""
        if path is None or _is_given(prefix + path, self._given):
            return
        type_ = self._type(path, fields)
        axis = self._axis(condition.container, prefix + path, type_) if type_ is not None else None
        if axis is not None:
            before = self._found.get(axis.path)
            self._found[axis.path] = axis if before is None else _both(before, axis)
            self.used.append(condition.span)

    def _type(self, path: str, fields: dict[str, plan_.ValueType]) -> plan_.ValueType | None:
        """Return the type of a parameter, by its path."""
        first, *rest = path.split(".")
        type_ = fields.get(first)
        for name in rest:
            if not isinstance(type_, plan_.StructType | plan_.ActorType):
                return None
            structure = self._plan.structures.find(type_)
            field = structure.fields.get(name) if structure is not None else None
            type_ = field.type if field is not None else None
        return type_

    def _axis(self, container: Expression, path: str, type_: plan_.ValueType) -> Axis | None:
        if isinstance(container, ListOf):
            numbers = [number_of(item, self._constants) for item in container.items]
            known = [number for number in numbers if number is not None]
            texts = dict.fromkeys(item.span.text for item in container.items)
            is_ordered = len(known) == len(texts)
            return Choices(path, tuple(texts), tuple(known) if is_ordered else None, container.span)
        if not isinstance(container, RangeOf):
            return None
        low, high = (number_of(bound, self._constants) for bound in (container.low, container.high))
        if low is None or high is None:  # bounds that depend on other parameters: each run draws
            return None
        is_whole = isinstance(type_, plan_.PrimitiveType) and type_.name != "float"
        return Interval(path, min(low, high), max(low, high), is_whole, type_, container.span)


def _check_argument(shown: str, path: str | None, invocation: plan_.InvokeAction | plan_.InvokeScenario) -> None:
    """Raise `UsageError` if the text of the scenario has an argument for a parameter that shall vary."""
    for name, value in invocation.arguments:
        if name == path:
            raise UsageError(
                f"`{shown}` cannot vary: the scenario has an argument for it, `{value.span.text}`",
                value.span,
                help="remove the argument, or use a parameter of the scenario instead of it, and vary that one",
            )


def constants_of(plan: Plan) -> Environment:
    """Return an environment for constant expressions."""
    return Environment(Composed("constants", Fields()), plan)


def number_of(expression: Expression, constants: Environment) -> float | None:
    """Return the value of a constant expression; None for others, and for values without order."""
    try:
        value = evaluate(expression, constants)
    except (EvaluationError, KeyError):
        return None
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None


def _conditions(members: Iterable[object]) -> Iterator[Contains]:
    for member in members:
        match member:
            case Constraint(condition=Contains() as condition, is_default=False):
                yield condition


def _both(first: Axis, second: Axis) -> Axis:
    """Intersect two axes of one parameter."""
    if isinstance(first, Interval) and isinstance(second, Interval):
        return _with_values(replace(second, low=max(first.low, second.low), high=min(first.high, second.high)))
    choices, other = (first, second) if isinstance(first, Choices) else (second, first)
    assert isinstance(choices, Choices)
    if isinstance(other, Choices):
        return _kept(choices, [text in other.texts for text in choices.texts])
    if choices.numbers is None:
        return choices
    return _kept(choices, [other.low <= number <= other.high for number in choices.numbers])


def _kept(axis: Choices, is_kept: list[bool]) -> Axis:
    numbers = axis.numbers and tuple(compress(axis.numbers, is_kept))
    return _with_values(replace(axis, texts=tuple(compress(axis.texts, is_kept)), numbers=numbers))


def _with_values(axis: Axis) -> Axis:
    """Return an axis.

    Raises:
        UsageError: It has no values.
    """
    if not axis.texts if isinstance(axis, Choices) else axis.low > axis.high:
        raise UsageError(f"the constraints of `{axis.path}` leave no value", axis.span)
    return axis


def path_of(item: Expression, *, of_it: bool) -> str | None:
    """Return the path of a parameter of the scenario, or of `it` in a `with` block; None for other expressions."""
    match item:
        case Member(Binding("it"), name) if of_it:
            return name
        case Field(name) | Global(name) if not of_it:
            return name
        case Member(base, name):
            around = path_of(base, of_it=of_it)
            return None if around is None else f"{around}.{name}"
        case _:
            return None


def _is_given(path: str, given: Collection[str]) -> bool:
    """Return whether a parameter, or a parent of it, has a given value."""
    return any(path == each or path.startswith(f"{each}.") for each in given)
