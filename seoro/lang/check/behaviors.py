"""Fifth pass: the `do` of scenarios and actions becomes a behavior of the plan (7.3.13, 7.2.2.4.7)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.arguments import bind
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions, scope_of
from seoro.lang.check.rewrite import substitute
from seoro.lang.check.unsupported import head, name_of, refuse_with
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import names, syntax
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import (
    DoFound,
    FieldSymbol,
    Kind,
    TypeSymbol,
    all_fields,
    all_methods,
    do_directive,
    is_open,
    lineage,
)
from seoro.lang.traits import ParameterTrait
from seoro.lang.types import Structured, is_known

MAX_DEPTH = 150  # of nested compositions
Arguments = tuple[tuple[str, plan.Expression], ...]
Traits = Mapping[str, Mapping[str, ParameterTrait]]


def labelled(member: ast.DoMember) -> list[tuple[ast.Name, ast.DoMember]]:
    """The behaviors with a label within a behavior, in the order of the text."""
    found: list[tuple[ast.Name, ast.DoMember]] = []
    stack = [member]
    while stack:
        current = stack.pop()
        if current.label is not None:
            found.append((current.label, current))
        if isinstance(current.body, ast.Composition):
            stack += reversed(current.body.members)
    return found


class Behaviors:
    """Elaborates the behavior of one scenario.

    Args:
        found: Its `do`.
        expressions: For expressions.
        traits: What the Python implementations of actions take, by qualified name and parameter.
    """

    def __init__(self, found: DoFound, expressions: Expressions, traits: Traits) -> None:
        self._directive = found.directive
        self._expressions = expressions
        self._program = expressions.program
        self._bag = expressions.bag
        self._traits = traits
        self._scope = scope_of(found.owner, found.home)
        self._owner = found.owner
        self._lookup = expressions.lookup
        labels: dict[str, ast.DoMember] = {}
        for label, member in labelled(found.directive.member):
            first = labels.setdefault(label.text, member)
            if first is not member:
                self._bag.add(names.Duplicate(label.span, "label", label.text, first.span))
        self._events = Events(expressions, self._scope, labels)

    def elaborate(self) -> plan.Behavior | None:
        """The behavior; None if it is wrong, which is reported."""
        return self._member(self._directive.member, 0)

    def _member(self, member: ast.DoMember, depth: int) -> plan.Behavior | None:
        label = member.label.text if member.label is not None else None
        body = member.body
        match body:
            case ast.Composition():
                return self._composition(body, label, depth)
            case ast.BehaviorInvocation():
                return self._invocation(body, label)
            case ast.WaitDirective(event, span):
                found = self._events.specification(event)
                return None if found is None else plan.Wait(label, found, span)
            case ast.EmitDirective():
                return self._emit(body, label)
            case ast.CallDirective(invocation, span):
                self._bag.add(NotSupported(head(span, "call"), Construct.CALL, name_of(invocation)))
                return None
            case ast.InvalidStatement():
                return None
            case _:
                assert_never(body)

    def _composition(self, node: ast.Composition, label: str | None, depth: int) -> plan.Behavior | None:
        if depth >= MAX_DEPTH:
            self._bag.add(syntax.TooDeep(head(node.span, node.operator), MAX_DEPTH))
            return None
        if node.arguments is not None:
            self._bag.add(NotSupported(node.arguments.span, Construct.COMPOSITION_ARGUMENTS))
        refuse_with(node.modifications, self._bag)
        elaborated = [self._member(member, depth + 1) for member in node.members]
        members = tuple(member for member in elaborated if member is not None)
        span = head(node.span, node.operator)
        match node.operator:
            case "serial":
                return plan.Serial(label, members, span)
            case "parallel":
                return plan.Parallel(label, members, span)
            case _:
                return plan.OneOf(label, members, span)

    # ------------------------------------------------------------ events

    def _emit(self, node: ast.EmitDirective, label: str | None) -> plan.Behavior | None:
        found = self._events.named(node.event)
        if found is None:
            return None
        reference, symbol = found
        if isinstance(reference, plan.PhaseEvent) and reference.phase is plan.Phase.START:
            self._bag.add(messages.EmitStart(node.event.span))
            return None
        name = node.event.text
        parameters = symbol.parameters if symbol is not None else {}
        given = bind(self._expressions, name, parameters, node.arguments, self._scope)
        arguments = self._complete(name, parameters, given, node.span)
        return plan.Emit(label, reference, arguments, node.span)

    # ------------------------------------------------------------ invocations

    def _invocation(self, node: ast.BehaviorInvocation, label: str | None) -> plan.Behavior | None:
        refuse_with(node.modifications, self._bag, is_invocation=True)
        call = node.invocation
        match call.function:
            case ast.NameExpression(name):
                symbol, actor = self._unprefixed(name)
            case ast.FieldAccess(base, name):
                symbol, actor = self._of_actor(base, name)
            case _:
                self._bag.add(messages.UnknownBehavior(call.function.span, call.function.span.text, None, ()))
                return None
        if symbol is None:
            return None
        if symbol.kind is Kind.MODIFIER:
            self._bag.add(NotSupported(name.span, Construct.MODIFIER_APPLICATION, name.text))
            return None
        return self._invoke(symbol, actor, node, label)

    def _unprefixed(self, name: ast.Name) -> tuple[TypeSymbol | None, plan.Expression | None]:
        """A behavior of the scenario's own actor, or of none."""
        program, space, own = self._program, self._scope.space, self._owner.actor
        if own is not None:
            found = self._lookup.behavior(space, own, name)
            if found is not None:
                return found, plan.Binding("actor", name.span)
        found = self._lookup.behavior(space, None, name) or self._lookup.modifier(space, None, name)
        if found is None and self._report_method(self._owner, name):
            return None, None
        if found is None and not program.is_lenient:
            owners: list[TypeSymbol | None] = [None, *(lineage(own) if own is not None else ())]
            hint = self._hint(name)
            self._bag.add(messages.UnknownBehavior(name.span, name.text, None, self._known(owners), hint))
        return found, None

    def _hint(self, name: ast.Name) -> str:
        """What to do about an unknown behavior that an actor has."""
        actors = [key[1].name for key in self._program.behaviors if key[1] is not None and key[2] == name.text]
        if actors:
            return f"it belongs to actor `{actors[0]}`: invoke it as `<actor>.{name.text}(...)`"
        return ""

    def _of_actor(self, base: ast.Expression, name: ast.Name) -> tuple[TypeSymbol | None, plan.Expression | None]:
        """A behavior of the actor that an expression gives."""
        actor = self._expressions.value(base, self._scope)
        if not is_known(actor.type):
            return None, None
        if not isinstance(actor.type, Structured) or actor.type.symbol.kind is not Kind.ACTOR:
            is_method = isinstance(actor.type, Structured) and self._report_method(actor.type.symbol, name)
            if not is_method:
                found_type = self._expressions.converter.describe(actor.type)
                self._bag.add(messages.NotAnActor(base.span, found_type))
            return None, None
        owner = actor.type.symbol
        space = self._scope.space
        found = self._lookup.behavior(space, owner, name)
        found = found or self._lookup.modifier(space, owner, name)
        if found is None and not self._report_method(owner, name) and not self._program.is_lenient:
            known = self._known(list(lineage(owner)))
            hint = ""
            if not known and self._lookup.behavior(space, None, name) is not None:
                hint = f"it belongs to no actor: invoke it as `{name.text}(...)`"
            self._bag.add(messages.UnknownBehavior(name.span, name.text, owner.name, known, hint))
        return found, actor.expression

    def _report_method(self, owner: TypeSymbol, name: ast.Name) -> bool:
        if self._lookup.member(self._scope.space, all_methods(owner), name) is not None:
            self._bag.add(messages.MethodInvoked(name.span, name.text))
            return True
        return False

    def _known(self, owners: list[TypeSymbol | None]) -> tuple[str, ...]:
        return tuple(name for _, owner, name in self._program.behaviors if owner in owners)

    def _invoke(
        self, symbol: TypeSymbol, actor: plan.Expression | None, node: ast.BehaviorInvocation, label: str | None
    ) -> plan.Behavior:
        """The invocation of a scenario or an action."""
        name, call = symbol.plan_name, node.invocation
        parameters, values = all_fields(symbol), self._expressions.values
        ranges: dict[str, plan.Expression] = {}
        traits = self._traits.get(name, {})
        given = bind(
            self._expressions,
            name,
            parameters,
            call.arguments,
            self._scope,
            is_open(symbol),
            traits,
            ranges=ranges,
        )
        values.check_conditions(symbol, given)
        constraints = [_within(parameter, bounds) for parameter, bounds in ranges.items()]
        constraints += self._with_block(node.modifications, symbol)
        is_constrained = node.modifications is not None
        missing = () if is_constrained else values.lacking_of(symbol, {**given, **ranges})
        if missing:
            self._bag.add(messages.MissingArgument(call.span, name, missing[0]))
        arguments = tuple((name, given[name]) for name in parameters if name in given)
        is_atomic = symbol.kind is Kind.ACTION and do_directive(symbol) is None
        make = plan.InvokeAction if is_atomic else plan.InvokeScenario
        return make(label, name, actor, arguments, tuple(constraints), call.span)

    def _with_block(self, block: ast.WithBlock | None, symbol: TypeSymbol) -> list[plan.ConstraintMember]:
        """The constraints in the `with` block of an invocation, in which `it` is what is invoked."""
        scope = replace(self._scope, it=Structured(symbol), is_it_bound=True)
        found: list[plan.ConstraintMember] = []
        for member in block.members if block is not None else ():
            if isinstance(member, ast.KeepConstraint | ast.RemoveDefault):
                constraint = self._expressions.constraints.member(member, scope)
                found += [constraint] if constraint is not None else []
        return found

    def _complete(
        self,
        owner: str,
        parameters: Mapping[str, FieldSymbol],
        given: Mapping[str, plan.Expression],
        span: Span,
    ) -> Arguments:
        """A value for each parameter of an event: what is given, else its default, with the values that it refers
        to put in."""
        values = dict(given)
        defaults: dict[str, plan.Expression] = {}
        for parameter in parameters.values():
            value = self._expressions.values.default(parameter)
            if parameter.name in given:
                continue
            if value is None:
                self._bag.add(messages.MissingArgument(span, owner, parameter.name))
            else:
                defaults[parameter.name] = value
        for name, value in self._expressions.values.ordered(defaults, parameters).items():
            values[name] = substitute(value, values)
        return tuple((name, values[name]) for name in parameters if name in values)


def _within(parameter: str, bounds: plan.Expression) -> plan.ConstraintMember:
    """What a range means that is given for a parameter that holds one number (7.3.5.1.3)."""
    span = bounds.span
    path = plan.Member(plan.Binding("it", span), parameter, span)
    return plan.Constraint(plan.Contains(path, bounds, span), False, span)
