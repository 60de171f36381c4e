"""Instances that overrides settle: they fix the constrained parameters, and defaults give the others.

Then the solver has nothing to choose. It would find the same values at a hundred times the cost, which is most of
the time of a short run in a campaign. Where anything is open or broken, the solver decides, and explains.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from seoro.lang import solve
from seoro.lang.plan import Call, Compare, Constraint, Expression, Field, FieldDeclaration, Global, Structure, walk
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
        given = dict(_values(roots, overrides, environment, evaluate))
        conditions = [*_conditions(roots, given), *_from_outside(overrides)]
        fields.update(given)
        is_settled = all(evaluate(condition, environment) for condition in conditions)
    except (_Open, EvaluationError):
        is_settled = False
    fields.clear()
    if is_settled:
        _set(fields, roots, given | times, environment, evaluate)
    return is_settled


def _values(
    roots: tuple[Structure, ...], overrides: tuple[Constraint, ...], environment: Environment, evaluate: Evaluate
) -> Iterator[tuple[str, Value]]:
    """Yield the values of overrides that are constants for whole scalar parameters."""
    declared = {name: field for root in roots for name, field in root.fields.items()}
    for override in overrides:
        match override.condition:
            case Compare("==", Field(name) | Global(name), value) if name in declared and _is_constant(value):
                domain = domain_of(declared[name].type)
                if domain is None or declared[name].is_variable:
                    raise _Open
                constant = evaluate(value, environment)
                if not contains(natural(solve.Cell(name, declared[name].span, domain)), constant):
                    raise _Open
                yield name, constant


def _is_constant(value: Expression) -> bool:
    return not any(isinstance(part, Field | Global | Call) for part in walk(value))


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


def _from_outside(overrides: tuple[Constraint, ...]) -> Iterator[Expression]:
    """Yield the conditions of overrides; two of one parameter may contradict each other."""
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
