"""Events: what `@...` refers to, and event specifications (7.3.10)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.expressions import Expressions, Scope
from seoro.lang.check.unsupported import head
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import EventSymbol, all_events, is_open
from seoro.lang.types import BOOL, EventObject, Quantity, RangeOf, Type
from seoro.lang.units import dimension

PHASES: Mapping[str, plan.Phase] = {phase.value: phase for phase in plan.Phase}
TIME = Quantity(dimension({"s": 1}))


class Events:
    """Resolves events in the body of one scenario.

    Args:
        expressions: For conditions and durations.
        scope: The scope of the scenario.
        labels: The behaviors with a label in it.
    """

    def __init__(self, expressions: Expressions, scope: Scope, labels: Mapping[str, ast.DoMember]) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._scope = scope
        self._labels = labels
        assert scope.owner is not None
        self._owner = scope.owner
        self._declared = all_events(scope.owner)

    def specification(self, node: ast.EventSpecification) -> plan.EventSpecification | None:
        """An event specification; None if it is wrong, which is reported."""
        match node:
            case ast.ElapsedExpression(duration, span):
                return plan.Elapsed(self.duration(duration), span)
            case ast.EventOccurrence():
                return self._occurrence(node)
            case ast.RiseExpression(span=span):
                self._bag.add(NotSupported(head(span, "rise"), Construct.RISE))
            case ast.FallExpression(span=span):
                self._bag.add(NotSupported(head(span, "fall"), Construct.FALL))
            case ast.EveryExpression(span=span):
                self._bag.add(NotSupported(head(span, "every"), Construct.EVERY))
            case ast.BoolCondition(span=span):
                self._bag.add(NotSupported(span, Construct.BOOL_CONDITION))
            case _:
                assert_never(node)
        return None

    def duration(self, node: ast.Expression) -> plan.Expression:
        """A duration, or a range of them."""
        found = self._expressions.value(node, self._scope, TIME)
        target: Type = RangeOf(TIME) if isinstance(found.type, RangeOf) else TIME
        return self._expressions.converter.convert(found, target, "the duration")

    def _occurrence(self, node: ast.EventOccurrence) -> plan.EventSpecification | None:
        found = self._reference(node.path)
        if found is None:
            return None
        reference, symbol = found
        if node.condition is None:
            return plan.OnEvent(reference, None, None, node.span)
        scope = self._scope
        if node.name is not None:
            if symbol is None:
                symbol = EventSymbol(node.path.span.text, self._owner, node.path.span)
            scope = replace(scope, bindings={**scope.bindings, node.name.text: EventObject(symbol)})
        if not isinstance(node.condition, ast.BoolCondition):
            self._refuse_condition(node.condition)
            return None
        condition = self._expressions.converted(node.condition.condition, BOOL, scope, "the condition")
        name = node.name.text if node.name is not None else None
        return plan.OnEvent(reference, name, condition, node.span)

    def _refuse_condition(self, condition: ast.EventCondition) -> None:
        match condition:
            case ast.ElapsedExpression(span=span):
                self._bag.add(NotSupported(head(span, "elapsed"), Construct.ELAPSED_CONDITION))
            case _:
                self.specification(condition)

    def _reference(self, path: ast.Expression) -> tuple[plan.EventReference, EventSymbol | None] | None:
        """What an event path refers to; None if it is wrong, which is reported."""
        match path:
            case ast.NameExpression(name):
                return self.named(name)
            case ast.FieldAccess(ast.NameExpression(label), name) if label.text in self._labels:
                if name.text in PHASES:
                    return plan.PhaseEvent(label.text, PHASES[name.text], path.span), None
                if isinstance(self._labels[label.text].body, ast.BehaviorInvocation):
                    self._bag.add(NotSupported(path.span, Construct.FOREIGN_EVENT, name.text))
                else:
                    self._bag.add(messages.UnknownPhase(name.span, label.text, name.text))
            case ast.FieldAccess(base, name):
                self._foreign(base, name, path.span)
            case _:
                self._bag.add(messages.NoEvent(path.span))
        return None

    def _foreign(self, base: ast.Expression, name: ast.Name, span: Span) -> None:
        """An event of another object: refused, unless there is no such object."""
        if isinstance(base, ast.NameExpression) and not self._is_object(base.name):
            if not self._expressions.program.is_lenient and not is_open(self._owner):
                candidates = (*self._labels, *(field.text for field in self._scope.fields.values()))
                self._bag.add(messages.UnknownLabel(base.span, base.name.text, candidates))
            return
        self._bag.add(NotSupported(span, Construct.FOREIGN_EVENT, name.text))

    def _is_object(self, name: ast.Name) -> bool:
        """Whether a name stands for something that may have events."""
        if name.namespace is None and name.text in self._scope.bindings:
            return True
        lookup, space = self._expressions.lookup, self._scope.space
        is_global = lookup.global_parameter(space, name) is not None
        return is_global or lookup.member(space, self._scope.fields, name) is not None

    def named(self, name: ast.Name) -> tuple[plan.EventReference, EventSymbol | None] | None:
        """An event of the scenario itself; None if there is none, which is reported."""
        declared = self._expressions.lookup.member(self._scope.space, self._declared, name)
        if declared is not None:
            return plan.DeclaredEvent(declared.name, name.span), declared
        if name.text in PHASES:
            return plan.PhaseEvent(None, PHASES[name.text], name.span), None
        if not is_open(self._owner) and not self._expressions.program.is_lenient:
            known = (*(event.text for event in self._declared.values()), *PHASES)
            self._bag.add(messages.UnknownEvent(name.span, name.text, known))
        return None
