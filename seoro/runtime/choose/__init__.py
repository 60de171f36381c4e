"""How instances get their values: at once where defaults decide, by constraint solving where they do not."""

from __future__ import annotations

from dataclasses import replace

from seoro.lang.plan import Construct
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import empty, is_plain, make_plain, scope_of
from seoro.runtime.environment import Calls, Environment, Evaluate
from seoro.runtime.values import Actor, Struct


def construct(expression: Construct, environment: Environment, evaluate: Evaluate) -> Struct | Actor:
    """The value of an expression that constructs a struct.

    Raises:
        EvaluationError: An argument or a default has no value, or there are none that meet all constraints.
    """
    given = {name: evaluate(value, environment) for name, value in expression.arguments}
    structure = expression.structures.of(expression.type)
    if is_plain(structure, given):
        return make_plain(structure, given, expression.structures, environment, evaluate)
    from seoro.runtime.choose.choose import choose  # noqa: PLC0415 - seldom needed
    from seoro.runtime.choose.request import Request  # noqa: PLC0415 - the same
    from seoro.runtime.choose.slots import Slot, value_slot  # noqa: PLC0415

    if environment.calls is None:
        environment = replace(environment, calls=Calls())
    made = empty(structure, environment.path, Fields())
    slot: Slot = value_slot(made, environment, expression.span)
    inside = scope_of(made, environment)
    choose(Request(made, (structure,), given, inside, expression.structures, evaluate, value=slot))
    return made
