"""Which scenario runs (7.7.2): the one asked for, the only one, or the one named `main`, of the entry file."""

from __future__ import annotations

from seoro.errors import InvalidScenario
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Message
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.source import Span
from seoro.lang.symbols import TypeSymbol

DEFAULT = "main"


def find_entry(checked: Checked, name: str | None) -> TypeSymbol:
    """The scenario to run; `InvalidScenario` if it cannot be told."""
    file = checked.sources.entry.file
    top = Span(file, 0, 0)
    candidates = checked.scenarios
    if name is not None:
        named = _called(name, candidates)
        if len(named) != 1:
            missing = messages.UnknownEntry(top, name, candidates)
            raise _invalid(messages.AmbiguousEntry(top, named) if named else missing)
        chosen = named[0]
    elif not candidates:
        raise _invalid(messages.NoScenario(top))
    elif len(candidates) == 1:
        chosen = candidates[0]
    elif len(named := _called(DEFAULT, candidates)) == 1:
        chosen = named[0]
    else:
        raise _invalid(messages.AmbiguousEntry(top, candidates))
    symbol = next(
        symbol
        for symbol in checked.program.behaviors.values()
        if symbol.plan_name == chosen and symbol.span.file is file
    )
    if symbol.actor is not None:
        raise _invalid(messages.ActorEntry(symbol.span, chosen))
    return symbol


def _called(name: str, candidates: tuple[str, ...]) -> tuple[str, ...]:
    """The scenarios that a name means: the one with exactly this name, else those of any namespace."""
    if name in candidates:
        return (name,)
    return tuple(candidate for candidate in candidates if candidate.endswith(f"::{name}"))


def _invalid(message: Message) -> InvalidScenario:
    return InvalidScenario((message.diagnostic(),))
