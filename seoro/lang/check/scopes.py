"""Scopes: the meaning of names in an expression."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from seoro.lang import plan
from seoro.lang.check.compositions import ANY_BEHAVIOR
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import Home, Space
from seoro.lang.symbols import FieldSymbol, Kind, Structured, Type, TypeSymbol, is_open
from seoro.lang.types import UNKNOWN


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
    """

    owner: TypeSymbol | None
    space: Space
    bindings: Mapping[str, Type] = field(default_factory=dict)
    fields: MemberTable[FieldSymbol] = field(default_factory=MemberTable)
    it: Type | None = None
    is_it_bound: bool = False
    it_value: plan.Expression | None = None
    is_running: bool = False


def scope_of(owner: TypeSymbol | None, home: Home) -> Scope:
    """Create the scope of members in a declaration or an extension; without an owner, of global parameters."""
    return _scope(owner, home, False) if owner is not None else Scope(None, home.space)


def running_scope(owner: TypeSymbol, home: Home) -> Scope:
    """Create the scope of members that are evaluated while an instance runs."""
    return _scope(owner, home, True)


def _scope(owner: TypeSymbol, home: Home, is_running: bool) -> Scope:
    """Create the scope of members; positional fields are fast."""
    bindings: dict[str, Type] = {"actor": Structured(owner.actor)} if owner.actor is not None else {}
    is_modifier = owner.kind is Kind.MODIFIER
    it = _modified(owner) if is_modifier else Structured(owner)
    return Scope(owner, home.space, bindings, owner.inventory.fields, it, is_modifier, None, is_running)


def _modified(modifier: TypeSymbol) -> Type:
    """Return the type of `it` in a modifier: the modified behavior (7.4.1.3)."""
    if modifier.of is not None:
        return Structured(modifier.of)
    return UNKNOWN if is_open(modifier) else ANY_BEHAVIOR
