"""Fifth pass: convert the `do` of scenarios and actions to behaviors of the plan (7.3.13, 7.2.2.4.7).

The directives `emit`, `call`, and `on`, which contains them, take no time.
"""

from __future__ import annotations

from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check import labels, targets, with_blocks
from seoro.lang.check.arguments import Binding
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import COMPOSITIONS, Scope, running_scope
from seoro.lang.check.times import Timing
from seoro.lang.diagnostics import behaviors, names
from seoro.lang.diagnostics import events as messages
from seoro.lang.members import MemberTable
from seoro.lang.symbols import DoFound, EventSymbol, Kind, Structured, is_open
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
                self._bag.add(behaviors.missing_argument, node.span, name, parameter.name)
        return tuple((name, values[name]) for name in parameters if name in values)

    def call(self, node: ast.CallDirective, label: str | None, scope: Scope) -> plan.CallMethod | None:
        """Elaborate `call <method>(...)`; the method needs no result."""
        found = self._expressions.calls.application(node.invocation, scope, is_directive=True)
        if isinstance(found.expression, plan.Call):
            return plan.CallMethod(label, found.expression, node.span)
        if is_known(found.type):
            self._bag.add(messages.not_a_method, node.invocation.span)
        return None


Arguments = tuple[tuple[str, plan.Expression], ...]


class Behaviors:
    """Elaborates the behavior of one scenario.

    Args:
        found: Its `do`.
        expressions: The expression checker.
    """

    def __init__(self, found: DoFound, expressions: Expressions) -> None:
        self._directive = found.directive
        self._expressions = expressions
        self._bag = expressions.bag
        self._scope = running_scope(found.owner, found.home)
        self._targets = targets.Targets(expressions, found.owner, found.home)
        self._events = Events(expressions, self._scope)
        self._directives = Directives(expressions, self._events)
        self._timing = Timing(expressions, self._scope)
        self._with_blocks = with_blocks.WithBlocks(expressions, self._scope)

    def elaborate(self) -> plan.Behavior | None:
        """Return the behavior; report an invalid one and return None."""
        first: dict[str, ast.Name] = {}
        for label, _ in labels.labelled(self._directive.member):
            if first.setdefault(label.text, label) is not label:
                self._bag.add(names.duplicate, label.span, "label", label.text, first[label.text].span)
        return self._member(self._directive.member)

    def _member(self, member: ast.DoMember) -> plan.Behavior | None:
        label = member.label.text if member.label is not None else None
        body = member.body
        match body:
            case ast.Composition():
                return self._composition(body, label)
            case ast.BehaviorInvocation():
                return self._invocation(body, label)
            case ast.WaitDirective(event, span):
                found = self._events.specification(event)
                return None if found is None else plan.Wait(label, found, span)
            case ast.EmitDirective():
                return self._directives.emit(body, label, self._scope)
            case ast.CallDirective():
                return self._directives.call(body, label, self._scope)
            case ast.InvalidStatement():
                return None
            case _:
                assert_never(body)

    def _composition(self, node: ast.Composition, label: str | None) -> plan.Behavior | None:
        times = self._timing.of_composition(node)
        constraints = tuple(self._with_blocks.constraints(node, COMPOSITIONS[node.operator]))
        modifications = self._with_blocks.of_composition(node)
        elaborated = [self._member(member) for member in node.members]
        members = tuple(member for member in elaborated if member is not None)
        span = node.span.head(node.operator)
        common = (label, members, times.duration, constraints, modifications, span)
        match node.operator:
            case "serial":
                return plan.Serial(*common)
            case "parallel":
                return plan.Parallel(*common, *times[1:])
            case _:
                return plan.OneOf(*common)

    # ------------------------------------------------------------ invocations

    def _invocation(self, node: ast.BehaviorInvocation, label: str | None) -> plan.Behavior | None:
        target = self._targets.find(node.invocation)
        modifications = self._with_blocks.of_invocation(node, target)
        return self._invoke(target, node, label, modifications) if target is not None else None

    def _invoke(
        self,
        target: targets.Target,
        node: ast.BehaviorInvocation,
        label: str | None,
        modifications: with_blocks.Modifications,
    ) -> plan.Behavior:
        """Build the invocation of a scenario or an action."""
        symbol, call = target.symbol, node.invocation
        name, parameters, values = symbol.plan_name, symbol.inventory.fields, self._expressions.values
        duration, rest = self._timing.of_invocation(call.arguments, parameters)
        traits, checker, scope = self._expressions.traits_of(symbol), self._expressions, self._scope
        binding = Binding(checker, name, parameters, scope, is_open(symbol), traits, may_be_ranges=True)
        given, ranges, types = binding.bind(rest), binding.ranges, binding.types
        values.check_conditions(symbol, given)
        constraints = [_within(parameter, bounds) for parameter, bounds in ranges.items()]
        constraints += self._with_blocks.constraints(node, Structured(symbol))
        may_be_given = self._with_blocks.may_constrain(node, modifications)
        missing = () if may_be_given else values.lacking_of(symbol, {**given, **ranges})
        if missing:
            self._bag.add(behaviors.missing_argument, call.span, name, missing[0])
        is_atomic = symbol.kind is Kind.ACTION and symbol.do is None
        arguments = tuple((name, given[name]) for name in parameters if name in given)
        common = (label, target.actor, arguments, tuple(constraints), duration, modifications, call.span, name)
        return plan.InvokeAction(*common, tuple(types.items())) if is_atomic else plan.InvokeScenario(*common)


def _within(parameter: str, bounds: plan.Expression) -> plan.ConstraintMember:
    """Constrain a parameter that holds one number to a range argument (7.3.5.1.3)."""
    span = bounds.span
    path = plan.Member(plan.Binding("it", span), parameter, span)
    return plan.Constraint(plan.Contains(path, bounds, span), False, span)
