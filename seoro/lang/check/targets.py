"""Targets of invocations: a scenario or an action, and its actor (7.3.5.1.3)."""

from __future__ import annotations

from typing import NamedTuple

from seoro.lang import ast, plan
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.scopes import scope_of
from seoro.lang.diagnostics import behaviors, listing, modifiers
from seoro.lang.namespaces import Home
from seoro.lang.program import actors_with
from seoro.lang.symbols import Kind, Structured, TypeSymbol, lineage
from seoro.lang.types import is_known


class Target(NamedTuple):
    """The invoked scenario or action, and its actor."""

    symbol: TypeSymbol
    actor: plan.Expression | None


class Targets:
    """Finds the targets of invocations.

    Args:
        expressions: The expression checker.
        owner: The scenario or action that contains the invocations.
        home: Namespace and library of its text.
    """

    def __init__(self, expressions: ExpressionChecker, owner: TypeSymbol, home: Home) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._program = expressions.program
        self._lookup = expressions.lookup
        self._owner = owner
        self._scope = scope_of(owner, home)

    def find(self, call: ast.FunctionApplication) -> Target | None:
        """Find the target of an invocation; report an unknown one and return None."""
        match call.function:
            case ast.NameExpression(name):
                return self._unprefixed(name)
            case ast.FieldAccess(base, name):
                return self._of_actor(base, name)
            case _:
                self._bag.add(behaviors.unknown_behavior, call.function.span, call.function.span.text, None, ())
                return None

    def _unprefixed(self, name: ast.Name) -> Target | None:
        """Find a behavior of the scenario's own actor, or of none."""
        space, own = self._scope.space, self._owner.actor
        if own is not None:
            found = self._lookup.behavior(space, own, name)
            if found is not None:
                return Target(found, plan.Binding("actor", name.span))
        found = self._lookup.behavior(space, None, name)
        if found is not None:
            return Target(found, None)
        if self._report_other(self._owner, own, name) or self._program.is_unread(name.text):
            return None
        owners: list[TypeSymbol | None] = [None, *(lineage(own) if own is not None else ())]
        hint = self._hint(name)
        self._bag.add(behaviors.unknown_behavior, name.span, name.text, None, self._known(owners), hint)
        return None

    def _hint(self, name: ast.Name) -> str:
        """Return help on a behavior that only an actor has."""
        if actors := actors_with(self._program.behaviors, name.text):
            return f"it belongs to actor `{actors[0]}`; invoke it as `<actor>.{name.text}(...)`"
        declared = self._lookup.type(self._scope.space, name)
        if isinstance(declared, TypeSymbol) and declared.kind is Kind.ACTOR:
            return behaviors.made_by_field(name.text, ())
        return ""

    def _of_actor(self, base: ast.Expression, name: ast.Name) -> Target | None:
        """Find a behavior of the actor that an expression denotes."""
        actor = self._expressions.value(base, self._scope)
        if not is_known(actor.type):
            return None
        if not isinstance(actor.type, Structured) or actor.type.symbol.kind is not Kind.ACTOR:
            is_method = isinstance(actor.type, Structured) and self._report_other(actor.type.symbol, None, name)
            if not is_method:
                found_type = self._expressions.converter.describe(actor.type)
                self._bag.add(behaviors.not_an_actor, base.span, found_type)
            return None
        owner = actor.type.symbol
        found = self._lookup.behavior(self._scope.space, owner, name)
        if found is not None:
            return Target(found, actor.expression)
        if not self._report_other(owner, owner, name) and not self._program.is_unread(name.text):
            known = self._known(list(lineage(owner)))
            hint = ""
            if not known and self._lookup.behavior(self._scope.space, None, name) is not None:
                hint = f"it belongs to no actor; invoke it as `{name.text}(...)`"
            elif not known:
                hint = self._hint_of_actor(name)
            self._bag.add(behaviors.unknown_behavior, name.span, name.text, owner.name, known, hint)
        return None

    def _hint_of_actor(self, name: ast.Name) -> str:
        """Return help with the actors that have a behavior."""
        actors = actors_with(self._program.behaviors, name.text)
        return f"it belongs to actor {listing(sorted(set(actors)), 'or')}" if actors else ""

    def _report_other(self, owner: TypeSymbol, actor: TypeSymbol | None, name: ast.Name) -> bool:
        """Report the name of a method or a modifier; return whether it is one."""
        space = self._scope.space
        if self._lookup.member(space, owner.inventory.methods, name) is not None:
            self._bag.add(behaviors.method_invoked, name.span, name.text)
            return True
        modifier = self._lookup.modifier(space, actor, name) or self._lookup.modifier(space, None, name)
        if modifier is not None:
            self._bag.add(modifiers.modifier_invoked, name.span, name.text)
        return modifier is not None

    def _known(self, owners: list[TypeSymbol | None]) -> tuple[str, ...]:
        return tuple(name for _, owner, name in self._program.behaviors if owner in owners)
