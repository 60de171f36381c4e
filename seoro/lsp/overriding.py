"""Members that override each other: events and methods that subtypes declare again, and their parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from seoro.lang.symbols import EventSymbol, MethodSymbol
from seoro.lsp.analysis import Analysis
from seoro.lsp.index import Place


def family(target: Place, analyses: Iterable[Analysis]) -> set[Place]:
    """Return the places of a declaration and of all that override it or that it overrides, in any step."""
    neighbours: dict[Place, set[Place]] = {}
    for analysis in analyses:
        for one, other in _overrides(analysis):
            neighbours.setdefault(one, set()).add(other)
            neighbours.setdefault(other, set()).add(one)
    found: set[Place] = set()
    pending = {target}
    while pending:
        found |= pending
        pending = {near for place in pending for near in neighbours.get(place, ())} - found
    return found


def _overrides(analysis: Analysis) -> Iterator[tuple[Place, Place]]:
    """Yield the places of declarations, each with that of the nearest overridden one."""
    target = analysis.index.target
    for symbol in analysis.checked.program.structured():
        if symbol.base is None:
            continue
        inherited = symbol.base.inventory
        pairs: list[tuple[EventSymbol | MethodSymbol, EventSymbol | MethodSymbol]] = []
        pairs += [(own, inherited.events[name]) for name, own in symbol.events.items() if name in inherited.events]
        pairs += [
            (own, inherited.methods[name]) for name, own in symbol.methods.items() if name in inherited.methods
        ]
        for own, overridden in pairs:
            alike = [(own.parameters[name], overridden.parameters.get(name)) for name in own.parameters]
            for one, other in [(own, overridden), *alike]:
                places = target(one), target(other) if other is not None else None
                if places[0] is not None and places[1] is not None:
                    yield places[0], places[1]
