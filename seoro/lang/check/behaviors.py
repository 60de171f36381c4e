"""Fifth pass: convert the `do` of scenarios and actions to behaviors of the plan (7.3.13, 7.2.2.4.7)."""

from __future__ import annotations

from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check import directives, events, labels, targets, with_blocks
from seoro.lang.check.arguments import Binding
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import COMPOSITIONS, running_scope
from seoro.lang.check.times import Timing
from seoro.lang.diagnostics import behaviors, names
from seoro.lang.symbols import DoFound, Kind, Structured, is_open

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
        self._events = events.Events(expressions, self._scope)
        self._directives = directives.Directives(expressions, self._events)
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
        ranges: dict[str, plan.Expression] = {}
        types: dict[str, plan.ValueType] = {}
        traits, checker, scope = self._expressions.traits_of(symbol), self._expressions, self._scope
        binding = Binding(checker, name, parameters, scope, is_open(symbol), traits, ranges, types)
        given = binding.bind(rest)
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
