"""Expressions that are written while a run is debugged: conditions of breakpoints, and watched values."""

from __future__ import annotations

from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidScenario
from seoro.lang import plan
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import running_scope
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_expression
from seoro.lang.source import SourceFile
from seoro.lang.types import BOOL

ORIGIN = "<debugger>"


def condition(scenario: Scenario, declaration: str, text: str) -> plan.Expression:
    """Read the condition of a breakpoint.

    Args:
        scenario: The file that runs.
        declaration: Name of the scenario or action whose names the condition may use, as in the plan.
        text: The condition.

    Raises:
        InvalidScenario: It is not a boolean expression.
    """
    return _read(scenario, declaration, text, is_condition=True)[0]


def watched(scenario: Scenario, declaration: str, text: str) -> tuple[plan.Expression, plan.ValueType | None]:
    """Read an expression of any type; return its static type, too, if the type has values.

    Args:
        scenario: The file that runs.
        declaration: As of `condition`.
        text: The expression.

    Raises:
        InvalidScenario: It is not an expression.
    """
    return _read(scenario, declaration, text, is_condition=False)


def _read(
    scenario: Scenario, declaration: str, text: str, *, is_condition: bool
) -> tuple[plan.Expression, plan.ValueType | None]:
    checked, bag = scenario.checked, Bag()
    symbol = next(each for each in checked.program.behaviors.values() if each.plan_name == declaration)
    node = parse_expression(SourceFile(ORIGIN, text), bag)
    found: plan.Expression | None = None
    type_: plan.ValueType | None = None
    if node is not None:
        expressions = Expressions(checked.program, bag, strict=False)
        scope = running_scope(symbol, symbol.home)
        if is_condition:
            found = expressions.converted(node, BOOL, scope, "the condition")
        else:
            typed = expressions.value(node, scope)
            if not len(bag):
                found, type_ = typed.expression, plan_type(typed.type, checked.program)
    if len(bag) or found is None:
        raise InvalidScenario(bag.diagnostics)
    return found, type_
