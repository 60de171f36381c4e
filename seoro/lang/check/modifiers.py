"""Applications of modifiers, in `with:` blocks and as members of types (7.3.12.4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from seoro.lang import ast, plan
from seoro.lang.check.arguments import Binding
from seoro.lang.check.declare import OVERRIDE
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.labels import WrongLabel, names_of
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import behaviors, modifiers
from seoro.lang.program import actors_with
from seoro.lang.symbols import FieldSymbol, Kind, Structured, TypeSymbol, is_open, lineage
from seoro.lang.types import is_known

_Arguments = tuple[tuple[str, plan.Expression], ...]


class Actor(NamedTuple):
    """An actor that an application of a modifier may omit."""

    symbol: TypeSymbol
    expression: plan.Expression


class Modified(NamedTuple):
    """Modified behavior.

    Args:
        symbol: The scenario or action; None for a composition.
        what: Its description, for messages; None if it is invalid, which is reported.
        actors: Actors that may be omitted, in order of precedence.
        parameters: Parameters of `it` in modifiers without `of`.
    """

    symbol: TypeSymbol | None
    what: str | None
    actors: tuple[Actor, ...]
    parameters: frozenset[str]


def own_actor(symbol: TypeSymbol) -> tuple[Actor, ...]:
    """Return the actor of a scenario, an action or a modifier, or the actor itself."""
    if symbol.kind is Kind.ACTOR:
        return (Actor(symbol, plan.Self(symbol.span)),)
    return () if symbol.actor is None else (Actor(symbol.actor, plan.Binding("actor", symbol.span)),)


class Modifiers:
    """Elaborates applications of modifiers in one scope.

    Args:
        expressions: The expression checker.
        scope: The scope, with the visible labels.
    """

    def __init__(self, expressions: Expressions, scope: Scope) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._lookup = expressions.lookup
        self._scope = scope

    def apply(self, node: ast.ModifierApplication, modified: Modified) -> plan.AppliedModifier | None:
        """Elaborate an application; report an invalid one and return None."""
        call = node.invocation
        match call.function:
            case ast.NameExpression(name) if name.namespace is None and name.text == OVERRIDE:
                return self._override(call)
            case ast.NameExpression(name):
                found = self._unprefixed(name, modified)
            case ast.FieldAccess(base, name):
                found = self._of_actor(base, name)
            case _:
                self._bag.add(modifiers.unknown_modifier, call.function.span, call.function.span.text, None, ())
                return None
        if found is None:
            return None
        symbol, actor = found
        self._check_target(symbol, name, modified)
        arguments, ranges = self._arguments(symbol, call)
        return plan.ModifierApplication(symbol.plan_name, actor, arguments, ranges, call.span)

    def _arguments(self, symbol: TypeSymbol, call: ast.FunctionApplication) -> tuple[_Arguments, _Arguments]:
        """Return the given values, and the ranges for parameters that hold one number."""
        parameters, owner = symbol.inventory.fields, symbol.qualified_name
        traits = self._expressions.traits_of(symbol)
        checker, scope = self._expressions, self._scope
        binding = Binding(checker, owner, parameters, scope, is_open(symbol), traits, may_be_ranges=True)
        given, ranges = binding.bind(call.arguments), binding.ranges
        missing = self._expressions.values.lacking_of(symbol, {**given, **ranges})
        if missing:
            self._bag.add(behaviors.missing_argument, call.span, owner, missing[0])
        return _in_order(given, parameters), _in_order(ranges, parameters)

    def _check_target(self, symbol: TypeSymbol, name: ast.Name, modified: Modified) -> None:
        """Check that a modifier `of` a scenario modifies that one or a subtype (7.3.12.2)."""
        if modified.what is None:
            return
        if symbol.of is None:
            self._expressions.applications.apply(
                symbol, self._scope.owner, name.span, modified.what, modified.parameters
            )
            return
        if modified.symbol is None or symbol.of not in lineage(modified.symbol):
            needed = symbol.of.qualified_name
            self._bag.add(modifiers.invalid_modified, name.span, symbol.name, needed, modified.what, symbol.span)

    # ------------------------------------------------------------ lookup

    def _unprefixed(self, name: ast.Name, modified: Modified) -> tuple[TypeSymbol, plan.Expression | None] | None:
        """Find a modifier of an omitted actor, or of none."""
        space = self._scope.space
        for actor in modified.actors:
            found = self._lookup.modifier(space, actor.symbol, name)
            if found is not None:
                return found, actor.expression
        found = self._lookup.modifier(space, None, name)
        if found is not None:
            return found, None
        owners: set[TypeSymbol | None] = {None}
        for actor in modified.actors:
            owners |= set(lineage(actor.symbol))
        is_hidden = modified.what is None or self._expressions.program.is_unread(name.text)
        if not is_hidden and not self._report_other(name, owners):
            known, hint = self._known(owners), self._hint(name)
            self._bag.add(modifiers.unknown_modifier, name.span, name.text, None, known, hint)
        return None

    def _of_actor(self, base: ast.Expression, name: ast.Name) -> tuple[TypeSymbol, plan.Expression | None] | None:
        """Find a modifier of the actor that an expression denotes."""
        actor = self._expressions.value(base, self._scope)
        if not is_known(actor.type):
            return None
        if not isinstance(actor.type, Structured) or actor.type.symbol.kind is not Kind.ACTOR:
            found_type = self._expressions.converter.describe(actor.type)
            self._bag.add(modifiers.modifier_of_no_actor, base.span, found_type)
            return None
        owner = actor.type.symbol
        found = self._lookup.modifier(self._scope.space, owner, name)
        if found is not None:
            return found, actor.expression
        owners: set[TypeSymbol | None] = set(lineage(owner))
        if not self._expressions.program.is_unread(name.text) and not self._report_other(name, owners):
            is_free = self._lookup.modifier(self._scope.space, None, name) is not None
            hint = f"it belongs to no actor; apply it as `{name.text}(...)`" if is_free else self._hint(name)
            known = self._known(owners)
            self._bag.add(modifiers.unknown_modifier, name.span, name.text, owner.name, known, hint)
        return None

    def _report_other(self, name: ast.Name, owners: set[TypeSymbol | None]) -> bool:
        """Report the name of a behavior or a method; return whether it is one."""
        for owner in owners:
            behavior = self._lookup.behavior(self._scope.space, owner, name)
            if behavior is not None:
                self._bag.add(modifiers.behavior_applied, name.span, name.text, behavior.kind.value)
                return True
        types = [owner for owner in (*owners, self._scope.owner) if owner is not None]
        if any(self._lookup.member(self._scope.space, type_.inventory.methods, name) for type_ in types):
            self._bag.add(modifiers.behavior_applied, name.span, name.text, "method")
            return True
        return False

    def _known(self, owners: set[TypeSymbol | None]) -> tuple[str, ...]:
        found = [name for _, owner, name in self._expressions.program.modifiers if owner in owners]
        return (*found, OVERRIDE)

    def _hint(self, name: ast.Name) -> str:
        """Return help on a modifier that only an actor has."""
        actors = actors_with(self._expressions.program.modifiers, name.text)
        return f"it belongs to actor `{actors[0]}`; apply it as `<actor>.{name.text}(...)`" if actors else ""

    # ------------------------------------------------------------ override (7.3.12.1.1)

    def _override(self, call: ast.FunctionApplication) -> plan.Override | None:
        """Elaborate `override(a, b[, mode])`, whose arguments are positional labels."""
        arguments = call.arguments.positional
        if call.arguments.named or not 2 <= len(arguments) <= 3:
            self._bag.add(modifiers.override_arguments, call.span)
            return None
        overridden, by = self._label_path(arguments[0]), self._label_path(arguments[1])
        mode = self._mode(arguments[2]) if len(arguments) == 3 else plan.OverrideMode.ON_START
        if overridden is None or by is None or mode is None:
            return None
        if overridden == by:
            self._bag.add(modifiers.override_of_itself, call.span, arguments[0].span.text)
        return plan.Override(overridden, by, mode, call.span)

    def _label_path(self, node: ast.Expression) -> plan.LabelPath | None:
        path = names_of(node)
        assert self._scope.owner is not None, "modifiers are applied while something runs"
        labels = self._expressions.labels.of(self._scope.owner)
        found = labels.path(path) if path else WrongLabel(node.span, ())
        if isinstance(found, WrongLabel):
            if any(self._expressions.program.is_unread(name.text) for name in path or ()):
                return None
            self._bag.add(modifiers.unknown_label, found.span, found.known)
            return None
        return found

    def _mode(self, node: ast.Expression) -> plan.OverrideMode | None:
        modes = {mode.value: mode for mode in plan.OverrideMode}
        if isinstance(node, ast.NameExpression) and node.name.text in modes:
            return modes[node.name.text]
        self._bag.add(modifiers.unknown_mode, node.span, tuple(modes))
        return None


def _in_order(given: Mapping[str, plan.Expression], parameters: Mapping[str, FieldSymbol]) -> _Arguments:
    return tuple((name, given[name]) for name in parameters if name in given)
