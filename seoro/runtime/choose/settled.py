"""Instances that overrides settle: they fix the constrained parameters, and defaults give the others.

Then the solver has nothing to choose. It would find the same values at a hundred times the cost, which is most of
the time of a short run in a campaign. Where anything is open or broken, the solver decides, and explains.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from seoro.lang import solve
from seoro.lang.plan import (
    Call,
    Compare,
    Constraint,
    Expression,
    Field,
    FieldDeclaration,
    Global,
    Literal,
    Structure,
    walk,
)
from seoro.lang.solve.sets import contains, natural
from seoro.runtime.choose.plain import fill
from seoro.runtime.choose.slots import domain_of
from seoro.runtime.values.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Fields, Value


class _Open(Exception):
    """A value is not settled."""


def settle(
    fields: Fields,
    roots: tuple[Structure, ...],
    overrides: tuple[Constraint, ...],
    times: dict[str, Value],
    environment: Environment,
    evaluate: Evaluate,
) -> bool:
    """Set the fields of an instance if its overrides settle them.

    Args:
        fields: The fields; empty.
        roots: Structures of the instance.
        overrides: Constraints by the user.
        times: Values of its timing parameters, if they are unconstrained.
        environment: Its environment.
        evaluate: Evaluates expressions.

    Returns:
        Whether the fields are set; else they are empty.

    Raises:
        EvaluationError: A default has no value.
    """
    try:
        given: dict[str, Value] = {}
        others: list[Constraint] = []
        for override in overrides:
            found = _constant(roots, override, environment, evaluate)
            if found is None or found[0] in given:  # two of one parameter may contradict each other
                others.append(override)
            else:
                given[found[0]] = found[1]
        conditions = [*_conditions(roots, given), *_from_outside(others)]
        fields.update(given)
        is_settled = all(evaluate(condition, environment) for condition in conditions)
    except (_Open, EvaluationError):
        is_settled = False
    fields.clear()
    if is_settled:
        _set(fields, roots, given | times, environment, evaluate)
    return is_settled


def _constant(
    roots: tuple[Structure, ...], override: Constraint, environment: Environment, evaluate: Evaluate
) -> tuple[str, Value] | None:
    """Return the name and the value if an override is a constant for a whole scalar parameter."""
    match override.condition:
        case Compare("==", Field(name) | Global(name), value) if _is_constant(value):
            declared = next((root.fields[name] for root in reversed(roots) if name in root.fields), None)
            if declared is None:
                return None
            domain = domain_of(declared.type)
            if domain is None or declared.is_variable:
                raise _Open
            constant = evaluate(value, environment)
            if not contains(natural(solve.Cell(name, declared.span, domain)), constant):
                raise _Open
            return name, constant
        case _:
            return None


def _is_constant(value: Expression) -> bool:
    return type(value) is Literal or not any(isinstance(part, Field | Global | Call) for part in walk(value))


def _conditions(roots: tuple[Structure, ...], given: Mapping[str, Value]) -> Iterator[Expression]:
    """Yield the conditions that must hold."""
    for root in roots:
        if root.latents or root.is_modified or not root.open_fields <= given.keys():
            raise _Open
        for member in root.members:
            match member:
                case FieldDeclaration():
                    pass
                case Constraint(condition=Compare("==", Field(name) | Global(name), _), is_default=True) if (
                    name in given
                ):
                    pass  # the override replaces it
                case Constraint(condition, is_default=False) if not _calls(condition):
                    yield condition
                case _:
                    raise _Open


def _from_outside(overrides: Sequence[Constraint]) -> Iterator[Expression]:
    """Yield the conditions of overrides that set no parameter."""
    for override in overrides:
        if _calls(override.condition):
            raise _Open
        yield override.condition


def _calls(condition: Expression) -> bool:
    """Return whether an expression calls a method, whose results the solver would remember."""
    return any(isinstance(part, Call) for part in walk(condition))


def _set(
    fields: Fields,
    roots: tuple[Structure, ...],
    values: Mapping[str, Value],
    environment: Environment,
    evaluate: Evaluate,
) -> None:
    """Set the fields: those with values, then the others by their defaults, in the order of their declaration."""
    fields.update(values)
    for root in roots:
        fill(fields, root, environment, evaluate)
    in_order = {name: fields[name] for root in roots for name in root.fields}
    rest = {name: value for name, value in fields.items() if name not in in_order}
    fields.clear()
    fields.update(in_order | rest)
