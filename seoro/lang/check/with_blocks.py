"""The `with:` blocks of behaviors: `until`, modifiers, and constraints on invocations (7.2.2.4.7)."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.modifiers import Actor, Modified, Modifiers, own_actor
from seoro.lang.check.scopes import COMPOSITIONS, Scope, parameters_of_invocation
from seoro.lang.check.targets import Target
from seoro.lang.symbols import Structured, Type
from seoro.lang.types import UNKNOWN

Modifications = tuple[plan.Modification, ...]


class WithBlocks:
    """Elaborates the `with:` blocks of one scenario; `it` is the invoked instance (7.3.5.1.3) or composition.

    Args:
        expressions: The expression checker.
        scope: The scope of the scenario, while it runs.
    """

    def __init__(self, expressions: Expressions, scope: Scope) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._scope = scope
        assert scope.owner is not None
        self._own = own_actor(scope.owner)

    def of_composition(self, node: ast.Composition) -> Modifications:
        """Elaborate the block of a composition."""
        it = COMPOSITIONS[node.operator]
        modified = Modified(None, f"a `{node.operator}`", self._own, frozenset(it.symbol.parameters))
        return self._elaborate(node.modifications, it, modified)

    def of_invocation(self, node: ast.BehaviorInvocation, target: Target | None) -> Modifications:
        """Elaborate the block of an invocation; an invalid target, which has been reported, is `None`."""
        if target is None:
            return self._elaborate(node.modifications, UNKNOWN, Modified(None, None, self._own, frozenset()))
        symbol, actor = target
        actors = self._own
        if symbol.actor is not None and actor is not None:
            actors = (Actor(symbol.actor, actor), *actors)
        modified = Modified(symbol, f"`{symbol.qualified_name}`", actors, parameters_of_invocation(symbol))
        return self._elaborate(node.modifications, Structured(symbol), modified)

    def constraints(self, node: ast.BehaviorInvocation | ast.Composition, it: Type) -> list[plan.ConstraintMember]:
        """Elaborate the constraints in the block of the behavior that `it` denotes."""
        if node.modifications is None:
            return []
        scope = replace(self._scope, it=it, is_it_bound=True)
        return list(self._expressions.constraints.among(node.modifications.members, scope))

    def may_constrain(self, node: ast.BehaviorInvocation, modifications: Modifications) -> bool:
        """Return whether the block may set parameters without arguments.

        It may do so by its constraints, or by those of a modifier with `of`.
        """
        members = node.modifications.members if node.modifications is not None else ()
        if any(isinstance(member, ast.KeepConstraint) for member in members):
            return True
        applied = {found.modifier for found in modifications if isinstance(found, plan.ModifierApplication)}
        declared = self._expressions.program.modifiers.values() if applied else ()
        return any(modifier.plan_name in applied and modifier.of is not None for modifier in declared)

    def _elaborate(self, block: ast.WithBlock | None, it: Type, modified: Modified) -> Modifications:
        if block is None:
            return ()
        scope = replace(self._scope, it=it, is_it_bound=True)
        events = Events(self._expressions, scope)
        modifiers = Modifiers(self._expressions, scope)
        found: list[plan.Modification | None] = []
        for member in block.members:
            match member:
                case ast.UntilDirective(event, span):
                    specification = events.specification(event)
                    found += [plan.Until(specification, span)] if specification is not None else []
                case ast.ModifierApplication():
                    found.append(modifiers.apply(member, modified))
                case ast.KeepConstraint() | ast.RemoveDefault() | ast.InvalidStatement():
                    pass
                case _:
                    assert_never(member)
        return tuple(modification for modification in found if modification is not None)
