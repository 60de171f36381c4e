"""What `it` is where no declared type says it: a composition, or whatever a modifier without `of` is applied to.

It has the parameters of compositions, with the types that 7.3.13 gives them, under names without a namespace. A
modifier without `of` may be applied to any behavior, and `it` then accesses the parameters of that application
(7.3.12.1.2): it may use those of any composition, and `applications.py` checks each application for what is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from seoro.lang import plan
from seoro.lang.members import MemberTable
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import (
    GLOBAL_NAMESPACE,
    CompositionSymbol,
    EnumSymbol,
    FieldSymbol,
    Home,
    Kind,
    Space,
    TypeSymbol,
    all_fields,
)
from seoro.lang.types import CompositionObject, Enumeration, Quantity, RangeOf, Type
from seoro.lang.units import dimension

OVERLAP, START_TO_START, END_TO_END, DURATION = "overlap", "start_to_start", "end_to_end", "duration"
TIME: Final = Quantity(dimension({"s": 1}))
_HOME: Final = Home(Space(GLOBAL_NAMESPACE), None)
_NOWHERE: Final = Span(SourceFile("<standard>", ""), 0, 0)
OVERLAP_KIND: Final = Enumeration(
    EnumSymbol(
        "overlap_kind",
        GLOBAL_NAMESPACE,
        _HOME,
        _NOWHERE,
        members={kind.value: number for number, kind in enumerate(plan.Overlap)},
        plan_name="overlap_kind",
    )
)
_TYPES: Final[Mapping[str, Type]] = {
    OVERLAP: OVERLAP_KIND,
    START_TO_START: TIME,
    END_TO_END: TIME,
    DURATION: RangeOf(TIME),
}


def _object(name: str, parameters: tuple[str, ...]) -> CompositionObject:
    found = MemberTable[FieldSymbol]()
    for text in parameters:
        found.add(FieldSymbol(text, _TYPES[text], None, None, _NOWHERE, _HOME, text, GLOBAL_NAMESPACE))
    return CompositionObject(CompositionSymbol(name, found))


COMPOSITIONS: Final[Mapping[str, CompositionObject]] = {
    "serial": _object("serial", (DURATION,)),
    "parallel": _object("parallel", tuple(_TYPES)),
    "one_of": _object("one_of", (DURATION,)),
}
ANY_BEHAVIOR: Final = _object("behavior", tuple(_TYPES))  # what a modifier without `of` modifies


def duration_of(symbol: TypeSymbol) -> FieldSymbol | None:
    """The parameter `duration` that every invocation has; None if a field of that name is declared instead."""
    if symbol.kind not in {Kind.SCENARIO, Kind.ACTION}:
        return None
    is_declared = any(field.text == DURATION for field in all_fields(symbol).values())
    return None if is_declared else ANY_BEHAVIOR.symbol.parameters[DURATION]


def parameters_of_invocation(symbol: TypeSymbol) -> frozenset[str]:
    """What an invocation has of these parameters: `duration` (7.6.2.4.1), which may be declared, too."""
    declared = [field.type for field in all_fields(symbol).values() if field.text == DURATION]
    fits = all(type_ in (TIME, RangeOf(TIME)) for type_ in declared)
    return frozenset({DURATION} if fits else ())
