"""Directives that take no time: `emit`, `call`, and `on`, which contains them (7.2.2.4.7)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.arguments import Binding
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import behaviors as behavior_messages
from seoro.lang.diagnostics import events as messages
from seoro.lang.members import MemberTable
from seoro.lang.symbols import EventSymbol
from seoro.lang.types import is_known


class Directives:
    """Elaborates directives.

    Args:
        expressions: The expression checker.
        events: The visible events.
    """

    def __init__(self, expressions: Expressions, events: Events) -> None:
        self._expressions = expressions
        self._events = events
        self._bag = expressions.bag

    def on(self, node: ast.OnDirective) -> plan.On | None:
        """Elaborate `on <event specification>:`; report an invalid one and return None."""
        specification, scope = self._events.specified(node.event)
        members: list[plan.Emit | plan.CallMethod | None] = []
        for member in node.members:
            match member:
                case ast.EmitDirective():
                    members.append(self.emit(member, None, scope))
                case ast.CallDirective():
                    members.append(self.call(member, None, scope))
                case ast.InvalidStatement():
                    pass
        if specification is None:
            return None
        return plan.On(specification, tuple(found for found in members if found is not None), node.span.head("on"))

    def emit(self, node: ast.EmitDirective, label: str | None, scope: Scope) -> plan.Emit | None:
        """Elaborate `emit <event>(...)` of an event of the type itself."""
        found = self._events.own(node.event)
        if found is None:
            return None
        event, symbol = found
        if isinstance(event, plan.PhaseEvent) and event.phase is plan.Phase.START:
            self._bag.add(messages.emit_start, node.event.span)
            return None
        return plan.Emit(label, event, self._arguments(node, symbol, scope), node.span)

    def _arguments(
        self, node: ast.EmitDirective, symbol: EventSymbol | None, scope: Scope
    ) -> tuple[tuple[str, plan.Expression], ...]:
        """Return the values of an event's parameters; the others need defaults."""
        name = node.event.text
        parameters = symbol.parameters if symbol is not None else MemberTable()
        values = Binding(self._expressions, name, parameters, scope).bind(node.arguments)
        for parameter in parameters.values():
            if parameter.name not in values and self._expressions.defaults.of(parameter) is None:
                self._bag.add(behavior_messages.missing_argument, node.span, name, parameter.name)
        return tuple((name, values[name]) for name in parameters if name in values)

    def call(self, node: ast.CallDirective, label: str | None, scope: Scope) -> plan.CallMethod | None:
        """Elaborate `call <method>(...)`; the method needs no result."""
        found = self._expressions.calls.application(node.invocation, scope, is_directive=True)
        if isinstance(found.expression, plan.Call):
            return plan.CallMethod(label, found.expression, node.span)
        if is_known(found.type):
            self._bag.add(messages.not_a_method, node.invocation.span)
        return None
