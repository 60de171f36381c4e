"""Type of `it` without a declared type: in a composition, and in a modifier without `of`.

It has the parameters of compositions with the types of 7.3.13, under names without a namespace. In a modifier
without `of`, `it` has the parameters of the modified behavior (7.3.12.1.2). It may use those of any composition;
`applications.py` checks each application for the used ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from seoro.lang import plan, symbols
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import GLOBAL_NAMESPACE, Home, Space
from seoro.lang.source import SourceFile, Span
from seoro.lang.units import dimension

OVERLAP, START_TO_START, END_TO_END, DURATION = "overlap", "start_to_start", "end_to_end", "duration"
TIME: Final = symbols.Quantity(dimension({"s": 1}))
_HOME: Final = Home(Space(GLOBAL_NAMESPACE), None)
_NOWHERE: Final = Span(SourceFile("<standard>", ""), 0, 0)
OVERLAP_KIND: Final = symbols.Enumeration(
    symbols.EnumSymbol(
        "overlap_kind",
        GLOBAL_NAMESPACE,
        _HOME,
        _NOWHERE,
        members={kind.value: number for number, kind in enumerate(plan.Overlap)},
        plan_name="overlap_kind",
    )
)
_TYPES: Final[Mapping[str, symbols.Type]] = {
    OVERLAP: OVERLAP_KIND,
    START_TO_START: TIME,
    END_TO_END: TIME,
    DURATION: symbols.RangeOf(TIME),
}


def _object(name: str, parameters: tuple[str, ...]) -> symbols.CompositionObject:
    found = MemberTable[symbols.FieldSymbol]()
    for text in parameters:
        found.add(symbols.FieldSymbol(text, _TYPES[text], None, None, _NOWHERE, _HOME, text, GLOBAL_NAMESPACE))
    return symbols.CompositionObject(symbols.CompositionSymbol(name, found))


COMPOSITIONS: Final[Mapping[str, symbols.CompositionObject]] = {
    "serial": _object("serial", (DURATION,)),
    "parallel": _object("parallel", tuple(_TYPES)),
    "one_of": _object("one_of", (DURATION,)),
}
ANY_BEHAVIOR: Final = _object("behavior", tuple(_TYPES))  # modified by a modifier without `of`


def duration_of(symbol: symbols.TypeSymbol) -> symbols.FieldSymbol | None:
    """Return the implicit parameter `duration` of invocations; None if a field of that name is declared."""
    if symbol.kind not in {symbols.Kind.SCENARIO, symbols.Kind.ACTION}:
        return None
    is_declared = any(field.text == DURATION for field in symbol.inventory.fields.values())
    return None if is_declared else ANY_BEHAVIOR.symbol.parameters[DURATION]


def parameters_of_invocation(symbol: symbols.TypeSymbol) -> frozenset[str]:
    """Return those of these parameters that an invocation has: `duration` (7.6.2.4.1), implicit or declared."""
    declared = [field.type for field in symbol.inventory.fields.values() if field.text == DURATION]
    fits = all(type_ in (TIME, symbols.RangeOf(TIME)) for type_ in declared)
    return frozenset({DURATION} if fits else ())
