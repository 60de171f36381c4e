"""Scopes: the meaning of names in an expression.

`it` has no declared type in a composition, and in a modifier without `of`. It has the parameters of compositions
with the types of 7.3.13, under names without a namespace. In a modifier without `of`, `it` has the parameters of
the modified behavior (7.3.12.1.2). It may use those of any composition; `applications.py` checks each application
for the used ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Final

from seoro.lang import plan, symbols
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import GLOBAL_NAMESPACE, Home, Space
from seoro.lang.source import SourceFile, Span
from seoro.lang.types import UNKNOWN
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


class Scope(Value):
    """Meaning of names in an expression.

    Args:
        owner: The type whose fields are visible, or None.
        space: The scope of the namespace statement.
        bindings: `actor`, the event objects of `as` clauses, and parameters of a method.
        fields: The visible fields.
        it: The type of `it`; None if it is undefined.
        is_it_bound: Whether `it` is a binding.
        it_value: Value of `it` if it is not a binding; None for the instance itself.
        is_running: Whether the owner runs, so that its labels denote invoked instances.
        invoked: Names of invocations that lead to their parameters, in constraints from outside.
    """

    owner: symbols.TypeSymbol | None
    space: Space
    bindings: Mapping[str, symbols.Type] = field(default_factory=dict)
    fields: MemberTable[symbols.FieldSymbol] = field(default_factory=MemberTable)
    it: symbols.Type | None = None
    is_it_bound: bool = False
    it_value: plan.Expression | None = None
    is_running: bool = False
    invoked: tuple[str, ...] = ()


def scope_of(owner: symbols.TypeSymbol | None, home: Home) -> Scope:
    """Create the scope of members in a declaration or an extension; without an owner, of global parameters."""
    return _scope(owner, home, False) if owner is not None else Scope(None, home.space)


def running_scope(owner: symbols.TypeSymbol, home: Home) -> Scope:
    """Create the scope of members that are evaluated while an instance runs."""
    return _scope(owner, home, True)


def _scope(owner: symbols.TypeSymbol, home: Home, is_running: bool) -> Scope:
    """Create the scope of members; positional fields are fast."""
    bindings: dict[str, symbols.Type] = (
        {"actor": symbols.Structured(owner.actor)} if owner.actor is not None else {}
    )
    is_modifier = owner.kind is symbols.Kind.MODIFIER
    it = _modified(owner) if is_modifier else symbols.Structured(owner)
    return Scope(owner, home.space, bindings, owner.inventory.fields, it, is_modifier, None, is_running)


def _modified(modifier: symbols.TypeSymbol) -> symbols.Type:
    """Return the type of `it` in a modifier: the modified behavior (7.4.1.3)."""
    if modifier.of is not None:
        return symbols.Structured(modifier.of)
    return UNKNOWN if symbols.is_open(modifier) else ANY_BEHAVIOR
