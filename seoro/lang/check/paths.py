"""Paths: expressions that lead to a field through other fields."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from seoro.lang import plan
from seoro.lang.check.compositions import duration_of
from seoro.lang.check.scopes import Scope
from seoro.lang.program import Program
from seoro.lang.symbols import CompositionObject, FieldSymbol, ListOf, Structured, Type


def paths_in(
    expression: plan.Expression, scope: Scope, program: Program
) -> Iterator[tuple[plan.Expression, tuple[FieldSymbol, ...]]]:
    """Yield the paths in an expression, each with its fields."""
    pending = [expression]
    while pending:
        current = pending.pop()
        fields = fields_on(current, scope, program)
        if fields:
            yield current, fields
        if fields is None or isinstance(current, plan.Index):
            pending += plan.parts(current)


def fields_on(expression: plan.Expression, scope: Scope, program: Program) -> tuple[FieldSymbol, ...] | None:
    """Return the fields of a path; None for other expressions."""
    match expression:
        case plan.Field(name):
            return (scope.fields[name],) if name in scope.fields else None
        case plan.Global(name):
            return (program.globals_by_name[name],)
        case plan.Self() | plan.Binding():
            return ()
        case plan.Index(items):
            return fields_on(items, scope, program)
        case plan.Member(base, name):
            before = fields_on(base, scope, program)
            if before is None:
                return None
            type_ = before[-1].type if before else _type_of_root(base, scope)
            if isinstance(type_, ListOf):
                type_ = type_.element
            fields = _fields_of(type_)
            return (*before, fields[name]) if name in fields else None
        case _:
            return None


def _fields_of(type_: Type | None) -> Mapping[str, FieldSymbol]:
    match type_:
        case Structured(symbol):
            duration = duration_of(symbol)
            return (
                symbol.inventory.fields
                if duration is None
                else {**symbol.inventory.fields, duration.name: duration}
            )
        case CompositionObject(composition):
            return composition.parameters
        case _:
            return {}


def _type_of_root(base: plan.Expression, scope: Scope) -> Type | None:
    """Return the type of a path's root if it is not a field."""
    if isinstance(base, plan.Binding) and not (base.name == "it" and scope.is_it_bound):
        return scope.bindings.get(base.name)
    return scope.it


def leads_to_variable(fields: tuple[FieldSymbol, ...]) -> bool:
    """Return whether a path leads to a variable; the fields of a variable are variables, too (7.3.6.1.2)."""
    return any(field.is_variable for field in fields)
