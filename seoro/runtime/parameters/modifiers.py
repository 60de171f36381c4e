"""Values of applied modifiers: actors, parameters and variables."""

from __future__ import annotations

from dataclasses import replace

from seoro.lang.plan import Structures
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.applied import Applied
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.fields import Fields
from seoro.runtime.values.values import Actor, Value


def actor_of(applied: Applied) -> Actor | None:
    """Return the actor of a modifier."""
    actor = evaluate(applied.plan.actor, applied.around) if applied.plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    return actor


def is_plain_modifier(applied: Applied) -> bool:
    """Whether a modifier needs no choice, neither for itself nor for the modified behavior."""
    structure = applied.modifier.structure
    if applied.has_values:
        return structure.is_plain
    given: dict[str, Value] = {name: True for name, _ in applied.plan.arguments}
    return not applied.plan.ranges and is_plain(structure, given)


def fill_modifier(applied: Applied, structures: Structures) -> None:
    """Fill the values of a modifier that needs no choice.

    Raises:
        EvaluationError: An argument or a default has no value.
    """
    if not applied.has_values:
        for name, value in applied.plan.arguments:
            applied.fields[name] = evaluate(value, applied.around)
        fill(applied.fields, applied.modifier.structure, structures, applied.inside, evaluate)


def enter_modifier(applied: Applied, path: str, structures: Structures) -> Instance:
    """Create an instance of a modifier for a run of the modified behavior.

    Args:
        applied: The modifier.
        path: Its position, as text.
        structures: Structures of all types.

    Raises:
        EvaluationError: A variable has no value.
    """
    structure, fields = applied.modifier.structure, applied.fields
    if applied.is_entered:
        fields = Fields()
        parameters = (declared.name for declared in structure.fields.values() if not declared.is_variable)
        fields.update((name, applied.fields[name]) for name in parameters)
    instance = Instance(path, fields, applied.modifier, applied.bindings, applied.inside.scenario)
    if applied.is_entered:
        fill(fields, structure, structures, replace(applied.inside, instance=instance), evaluate)
    applied.is_entered = True
    return instance
