"""What names mean where an expression stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING

from seoro.lang import plan
from seoro.lang.check.compositions import ANY_BEHAVIOR
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.symbols import FieldSymbol, Home, Kind, Space, TypeSymbol, all_fields, is_open
from seoro.lang.types import UNKNOWN, Structured, Type

if TYPE_CHECKING:
    from seoro.lang.check.labels import Labels


class Scope(Value):
    """What names mean where an expression stands.

    Args:
        owner: The type whose fields can be named; None if there is none.
        space: The scope of the text's namespace statement.
        bindings: `actor`, the event objects of `as` clauses, and parameters of a method.
        fields: The fields that can be named.
        it: The type of `it`; None if it stands for nothing.
        is_it_bound: Whether `it` is a binding.
        it_value: What `it` stands for if it is no binding; None for the instance itself.
        labels: The labels that stand for what was invoked under them; None before anything runs.
    """

    owner: TypeSymbol | None
    space: Space
    bindings: Mapping[str, Type] = field(default_factory=dict)
    fields: MemberTable[FieldSymbol] = field(default_factory=MemberTable)
    it: Type | None = None
    is_it_bound: bool = False
    it_value: plan.Expression | None = None
    labels: Labels | None = None


def scope_of(owner: TypeSymbol | None, home: Home, labels: Labels | None = None) -> Scope:
    """The scope of the members of a type, in its declaration or an extension; of None, of global parameters."""
    if owner is None:
        return Scope(None, home.space, labels=labels)
    bindings: dict[str, Type] = {"actor": Structured(owner.actor)} if owner.actor is not None else {}
    if owner.kind is Kind.MODIFIER:
        return Scope(owner, home.space, bindings, all_fields(owner), _modified(owner), True, None, labels)
    return Scope(owner, home.space, bindings, all_fields(owner), Structured(owner), False, None, labels)


def _modified(modifier: TypeSymbol) -> Type:
    """The type of `it` in a modifier: of what it modifies (7.4.1.3)."""
    if modifier.of is not None:
        return Structured(modifier.of)
    return UNKNOWN if is_open(modifier) else ANY_BEHAVIOR


def running_scope(owner: TypeSymbol, home: Home, labels: Labels) -> Scope:
    """The scope of the members of a type that are evaluated while an instance of it runs."""
    return scope_of(owner, home, labels)
