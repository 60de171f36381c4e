"""Messages for parameters without values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from seoro.errors import CONFLICT
from seoro.lang import solve
from seoro.lang.solve.terms import cells_of
from seoro.lang.source import Span
from seoro.runtime.choose.gather import OVERRIDE
from seoro.runtime.choose.slots import Rule
from seoro.runtime.values.environment import NoSolution

Rules: TypeAlias = Mapping[solve.Constraint, Rule | None]  # constraints with their rules
_MOST = 3  # constraints shown for an unbounded number


def no_bounds(unbounded: solve.Unbounded, rules: Rules) -> NoSolution:
    """Return the message for an unbounded value, with its constraints."""
    name, span = unbounded.cell.name, unbounded.cell.span
    about = [rule for each, rule in rules.items() if rule is not None and unbounded.cell in cells_of(each.term)]
    reason = f"`{name}` has no value: give it a default, a constraint or an override"
    where = "nothing gives it a value, or bounds it" if not about else "nothing bounds it on both sides"
    others = tuple((rule.span, "this leaves it without a bound") for rule in about[:_MOST])
    return NoSolution(reason, "E0443", ((span, where), *others))


def no_solution(conflict: solve.Conflict, rules: Rules) -> NoSolution:
    """Return the message for contradictory constraints."""
    places: list[tuple[Span, str]] = []
    written = [each for each in conflict.constraints if rules.get(each) is not None]
    for constraint in written or conflict.constraints:
        rule = rules.get(constraint)
        if rule is not None and rule.order[0] == OVERRIDE:
            text = "this was set from outside"
        elif constraint.strength is solve.Strength.DEFAULT:
            text = "this default is not overridden"
        else:
            text = "this has to hold"
        places.append((constraint.span, text))
    places += [(cell.span, f"`{cell.name}` cannot have such a value") for cell in conflict.limits]
    what = "these constraints cannot hold together" if len(places) > 1 else "this constraint cannot hold"
    hint = "a default gives way to a later `keep` with the parameter alone on its left side, `keep(x == 3)` or "
    hint += "`keep(x in [1..3])`, and to `remove_default(x)`"
    has_default = any(constraint.strength is solve.Strength.DEFAULT for constraint in conflict.constraints)
    message = f"{what}: {conflict.reason}" if conflict.reason else what
    return NoSolution(message, CONFLICT, tuple(places), hint if has_default else "")
