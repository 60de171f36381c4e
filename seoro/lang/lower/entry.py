"""Choice of the scenario to run (7.7.2): the requested one, the only one, or `main` of the entry file."""

from __future__ import annotations

from seoro.errors import InvalidScenario
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.source import Span
from seoro.lang.symbols import TypeSymbol

DEFAULT = "main"


def find_entry(checked: Checked, name: str | None) -> TypeSymbol:
    """Return the scenario to run.

    Raises:
        InvalidScenario: The scenario is missing or ambiguous.
    """
    file = checked.sources.entry.file
    top = Span(file, 0, 0)
    candidates = checked.scenarios
    if name is not None:
        named = _named(name, candidates)
        if len(named) != 1:
            missing = messages.unknown_entry(top, name, candidates)
            raise InvalidScenario((messages.ambiguous_entry(top, named) if named else missing,))
        chosen = named[0]
    elif not candidates:
        raise InvalidScenario((messages.missing_scenario(top),))
    elif len(candidates) == 1:
        chosen = candidates[0]
    elif len(named := _named(DEFAULT, candidates)) == 1:
        chosen = named[0]
    else:
        raise InvalidScenario((messages.ambiguous_entry(top, candidates),))
    symbol = next(
        symbol
        for symbol in checked.program.behaviors.values()
        if symbol.plan_name == chosen and symbol.span.file is file
    )
    if symbol.actor is not None:
        raise InvalidScenario((messages.actor_entry(symbol.span, chosen),))
    return symbol


def _named(name: str, candidates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the scenario with exactly this name, else those with it in any namespace."""
    if name in candidates:
        return (name,)
    return tuple(candidate for candidate in candidates if candidate.endswith(f"::{name}"))
