"""What values are asked for, of an instance and of what modifies it."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang import frozen
from seoro.lang.plan import Constraint, ConstraintMember, Structure, Structures
from seoro.runtime.choose.slots import Slot
from seoro.runtime.choose.times import Times
from seoro.runtime.environment import Environment, Evaluate
from seoro.runtime.values import HasFields, Value


class Attached(frozen.Value):
    """A modifier of an instance, whose values are chosen with those of the instance.

    Args:
        structure: What it is made of.
        environment: Its scope; it is the instance there.
        given: Values that it has from the start.
        constraints: What its arguments say.
        around: The scope of those.
    """

    structure: Structure
    environment: Environment
    given: Mapping[str, Value]
    constraints: tuple[ConstraintMember, ...]
    around: Environment


class Request(frozen.Value):
    """What values are asked for.

    Args:
        holder: The instance; its fields are `Fields`, and get the values.
        roots: What it is made of; for the entry scenario, the global parameters first.
        given: Values that it has from the start.
        environment: Its scope.
        constraints: What else holds for it, in an invocation.
        around: The scope of that, in which `it` is the instance; its own if there is none around it.
        overrides: What is set from outside.
        structures: The structures of all types.
        evaluate: Evaluates expressions.
        value: The place of the instance, if it is a struct or an actor.
        attached: What modifies it.
        times: Its parameters for times; None if it is no behavior.
    """

    holder: HasFields
    roots: tuple[Structure, ...]
    given: Mapping[str, Value]
    environment: Environment
    structures: Structures
    evaluate: Evaluate
    constraints: tuple[ConstraintMember, ...] = ()
    around: Environment | None = None
    overrides: tuple[Constraint, ...] = ()
    value: Slot | None = None
    attached: tuple[Attached, ...] = ()
    times: Times | None = None
