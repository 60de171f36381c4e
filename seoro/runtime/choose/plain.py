"""Plain instances, decided by given values and defaults: the usual case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from seoro.lang.plan import ActorType, FieldDeclaration, ListType, StructType, Structure
from seoro.runtime.values.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Actor, Fields, HasFields, Struct, Value, make_room


def is_plain(structure: Structure, given: Mapping[str, Value]) -> bool:
    """Whether an instance needs no choice."""
    return structure.is_plain and (not structure.open_fields or structure.open_fields <= given.keys())


def is_given(structure: Structure, given: Mapping[str, Value]) -> bool:
    """Whether all fields of an instance are given, so that it needs neither choice nor computation."""
    return structure.is_plain and structure.fields.keys() == given.keys()


def fill(fields: Fields, structure: Structure, environment: Environment, evaluate: Evaluate) -> None:
    """Fill the missing fields of a plain structure.

    Args:
        fields: The fields, including given values.
        structure: The structure of the instance.
        environment: Environment of the defaults.
        evaluate: Evaluates them.

    Raises:
        EvaluationError: A default has no value.
    """
    pending: set[str] = set()

    def compute(name: str) -> Value:
        declared = structure.fields[name]
        if name in pending:
            raise EvaluationError(f"the value of `{declared.span.text}` depends on itself", declared.span)
        pending.add(name)
        path = f"{environment.path}.{name}" if environment.path else name
        fields[name] = _value(declared, replace(environment, path=path), evaluate)
        return fields[name]

    make_room(len(structure.fields))
    fields.compute = compute
    for name in structure.fields:
        fields[name]
    fields.compute = None


def _value(declared: FieldDeclaration, environment: Environment, evaluate: Evaluate) -> Value:
    if declared.default is not None:
        return evaluate(declared.default, environment)
    match declared.type:
        case StructType() | ActorType():
            return make_plain(environment.plan.structures.of(declared.type), {}, environment, evaluate)
        case ListType():
            return ()
        case _:
            raise AssertionError("a plain structure has a default here")


def make_plain(
    structure: Structure, given: Mapping[str, Value], environment: Environment, evaluate: Evaluate
) -> Struct | Actor:
    """Construct a value of a plain structure.

    Args:
        structure: Its structure.
        given: Values of fields.
        environment: Surrounding environment; its path is that of the value.
        evaluate: Evaluates defaults.
    """
    fields = Fields()
    made = empty(structure, environment.path, fields)
    fields.update(given)
    fill(fields, structure, scope_of(made, environment), evaluate)
    return made


def empty(structure: Structure, path: str, fields: Fields) -> Struct | Actor:
    """Return a value without fields."""
    if isinstance(structure.type, ActorType):
        return Actor(structure.type, path, fields)
    return Struct(structure.type, fields)


def scope_of(made: HasFields, environment: Environment) -> Environment:
    """Return the environment of the members of a value constructed in another environment."""
    return replace(environment, instance=made, scenario=environment.outermost)
