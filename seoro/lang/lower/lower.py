"""Makes the plan of a scenario: its parameters with their values, and every scenario and action that it
reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import assert_never

from seoro.errors import InvalidScenario
from seoro.lang import plan
from seoro.lang.check.checker import Checked
from seoro.lang.check.expressions import Expressions, scope_of
from seoro.lang.check.plan_types import plan_type, struct_type
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.lower.entry import find_entry
from seoro.lang.lower.overrides import Overrides
from seoro.lang.symbols import FieldSymbol, TypeSymbol, all_events, all_fields, do_directive, lineage


def lower_scenario(checked: Checked, scenario: str | None, overrides: Mapping[str, str]) -> plan.Plan:
    """The plan of a scenario; `InvalidScenario` if it has errors, has no entry, or lacks a value."""
    if checked.errors:
        raise InvalidScenario(checked.errors)
    entry = find_entry(checked, scenario)
    lowering = _Lowering(checked)
    first = lowering.entry(entry, overrides)
    global_parameters = lowering.globals()
    if len(lowering.bag):
        raise InvalidScenario(lowering.bag.diagnostics)
    scenarios = {first.name: first}
    actions: dict[str, plan.Action] = {}
    pending = [first]
    while pending:
        for invocation in _invocations(pending.pop().body):
            if isinstance(invocation, plan.InvokeAction):
                if invocation.action not in actions:
                    actions[invocation.action] = lowering.action(invocation.action)
            elif invocation.scenario not in scenarios:
                scenarios[invocation.scenario] = lowering.scenario(invocation.scenario)
                pending.append(scenarios[invocation.scenario])
    return plan.Plan(first.name, scenarios, actions, global_parameters, checked.sources.entry.file.name)


def _invocations(body: plan.Behavior | None) -> Iterator[plan.InvokeAction | plan.InvokeScenario]:
    """All invocations in a behavior, in the order of the text."""
    stack = [body] if body is not None else []
    while stack:
        behavior = stack.pop()
        match behavior:
            case plan.Serial() | plan.Parallel() | plan.OneOf():
                stack += reversed(behavior.members)
            case plan.InvokeAction() | plan.InvokeScenario():
                yield behavior
            case plan.Wait() | plan.Emit():
                pass
            case _:
                assert_never(behavior)


class _Lowering:
    """Makes the parts of one plan."""

    def __init__(self, checked: Checked) -> None:
        self.bag = Bag()
        self._checked = checked
        self._program = checked.program
        self._expressions = Expressions(checked.program, self.bag, strict=False)
        self._symbols = {symbol.plan_name: symbol for symbol in checked.program.behaviors.values()}

    def entry(self, symbol: TypeSymbol, overrides: Mapping[str, str]) -> plan.Scenario:
        """The entry scenario, each of whose parameters has a value."""
        values: dict[str, plan.Expression] = {}
        lacking: dict[str, FieldSymbol] = {}
        fields = all_fields(symbol)
        for field in fields.values():
            value, missing = self._expressions.values.default(field)
            if value is not None:
                values[field.name] = value
            lacking.update(dict.fromkeys(missing, field))
        for name, condition in self._expressions.values.conditions(symbol):
            values[name] = plan.Literal(condition, fields[name].span)
            lacking.pop(name, None)
        values = Overrides(self._expressions, scope_of(symbol, symbol.home), self.bag).apply(values, overrides)
        self._expressions.values.check_conditions(symbol, values)
        for path, field in lacking.items():
            if not any(path == given or path.startswith(f"{given}.") for given in overrides):
                self.bag.add(messages.NoValue(field.span, path))
        return self._scenario(symbol, values)

    def scenario(self, name: str) -> plan.Scenario:
        """A scenario that is invoked; its invocations give what has no value here."""
        symbol = self._symbols[name]
        values: dict[str, plan.Expression] = {}
        for field in all_fields(symbol).values():
            value, missing = self._expressions.values.default(field)
            if value is not None and not missing:
                values[field.name] = value
        for field_name, condition in self._expressions.values.conditions(symbol):
            values[field_name] = plan.Literal(condition, all_fields(symbol)[field_name].span)
        return self._scenario(symbol, values)

    def _scenario(self, symbol: TypeSymbol, values: Mapping[str, plan.Expression]) -> plan.Scenario:
        fields = all_fields(symbol)
        given = self._expressions.values.ordered(values, fields)
        order = [name for name in fields if name not in given] + list(given)
        parameters = tuple(
            plan.Parameter(name, plan_type(fields[name].type, self._program), given.get(name), fields[name].span)
            for name in order
        )
        events = tuple(
            plan.Event(event.name, tuple(event.parameters), event.span) for event in all_events(symbol).values()
        )
        declared = do_directive(symbol)
        body = self._checked.behaviors[declared.owner] if declared is not None else None
        bases = tuple(base.plan_name for base in lineage(symbol))[1:]
        return plan.Scenario(symbol.plan_name, bases, parameters, events, body, symbol.span)

    def globals(self) -> tuple[plan.Parameter, ...]:
        """The global parameters, each after those that it refers to."""
        symbols = {symbol.name: symbol for symbol in self._program.globals.values()}
        values: dict[str, plan.Expression] = {}
        for symbol in symbols.values():
            value, missing = self._expressions.values.default(symbol)
            if missing or value is None:
                self.bag.add(messages.GlobalWithoutValue(symbol.span, symbol.text))
            else:
                values[symbol.name] = value
        return tuple(
            plan.Parameter(name, plan_type(symbols[name].type, self._program), value, symbols[name].span)
            for name, value in self._expressions.values.ordered(values, symbols).items()
        )

    def action(self, name: str) -> plan.Action:
        """The declaration of an action."""
        symbol = self._symbols[name]
        actor = struct_type(symbol.actor) if symbol.actor is not None else None
        assert actor is None or isinstance(actor, plan.ActorType)
        parameters = tuple(
            plan.ActionParameter(field.name, plan_type(field.type, self._program), field.span)
            for field in all_fields(symbol).values()
        )
        return plan.Action(name, actor, parameters, symbol.home.library, symbol.span)
