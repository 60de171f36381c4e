"""Request for a choice of values (`choose.py`)."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang import frozen
from seoro.lang.plan import Constraint, ConstraintMember, Structure
from seoro.runtime.choose.slots import Slot
from seoro.runtime.instances.applied import Attached
from seoro.runtime.instances.times import Times
from seoro.runtime.values.environment import Environment, Evaluate
from seoro.runtime.values.values import HasFields, Value


class Request(frozen.Value):
    """Request for the values of an instance.

    Args:
        holder: The instance; its fields are `Fields`, and get the values.
        roots: Its structures; for the entry scenario, the global parameters first.
        given: Given values.
        environment: Its environment.
        constraints: Constraints of its invocation.
        around: Environment of those, with the instance as `it`; by default, its own.
        overrides: Constraints by the user.
        evaluate: Evaluates expressions.
        value: Slot of the instance, if it is a struct or an actor.
        attached: Its modifiers.
        times: Its timing parameters; None if it has none.
    """

    holder: HasFields
    roots: tuple[Structure, ...]
    given: Mapping[str, Value]
    environment: Environment
    evaluate: Evaluate
    constraints: tuple[ConstraintMember, ...] = ()
    around: Environment | None = None
    overrides: tuple[Constraint, ...] = ()
    value: Slot | None = None
    attached: tuple[Attached, ...] = ()
    times: Times | None = None
