"""Makes the plan of a scenario: its parameters with their values, and every scenario and action that it
reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import assert_never

from seoro.errors import InvalidScenario
from seoro.lang import plan
from seoro.lang.check.checker import Checked
from seoro.lang.check.expressions import Expressions, scope_of
from seoro.lang.check.plan_types import struct_type
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.lower.entry import find_entry
from seoro.lang.lower.overrides import Overrides
from seoro.lang.symbols import TypeSymbol, all_events, all_fields, do_directive, lineage, may_lack_values


def lower_scenario(checked: Checked, scenario: str | None, overrides: Mapping[str, str]) -> plan.Plan:
    """The plan of a scenario; `InvalidScenario` if it has errors, has no entry, or lacks a value."""
    if checked.errors:
        raise InvalidScenario(checked.errors)
    entry = find_entry(checked, scenario)
    lowering = _Lowering(checked)
    first = lowering.scenario(entry)
    given = lowering.overrides(entry, overrides)
    global_parameters = lowering.globals(entry, overrides)
    lowering.check_values(entry, overrides)
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
                scenarios[invocation.scenario] = lowering.invoked(invocation.scenario)
                pending.append(scenarios[invocation.scenario])
    structures = checked.program.structures
    file = checked.sources.entry.file.name
    return plan.Plan(first.name, given, scenarios, actions, global_parameters, structures, file, checked.coverage)


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

    def scenario(self, symbol: TypeSymbol) -> plan.Scenario:
        """A scenario with everything that it inherits."""
        events = tuple(
            plan.Event(event.name, tuple(event.parameters), event.span) for event in all_events(symbol).values()
        )
        declared = do_directive(symbol)
        body = self._checked.behaviors[declared.owner] if declared is not None else None
        bases = tuple(base.plan_name for base in lineage(symbol))[1:]
        structure = self._expressions.values.structure(symbol)
        return plan.Scenario(symbol.plan_name, bases, structure, events, body, symbol.span)

    def invoked(self, name: str) -> plan.Scenario:
        """A scenario by its name."""
        return self.scenario(self._symbols[name])

    def action(self, name: str) -> plan.Action:
        """The declaration of an action."""
        symbol = self._symbols[name]
        actor = struct_type(symbol.actor) if symbol.actor is not None else None
        assert actor is None or isinstance(actor, plan.ActorType)
        bases = tuple(base.plan_name for base in lineage(symbol))[1:]
        structure = self._expressions.values.structure(symbol)
        return plan.Action(name, bases, actor, structure, symbol.home.library, symbol.span)

    def globals(self, entry: TypeSymbol, overrides: Mapping[str, str]) -> plan.Structure:
        """The global parameters; those that nothing can give a value are reported."""
        for declaration, home in self._program.global_declarations:
            may_be_constrained = declaration.constraints or may_lack_values(entry)
            for name in declaration.names if not may_be_constrained else ():
                symbol = self._program.globals[home.namespace_of(name), name.text]
                lacking = self._expressions.values.lacking(symbol)
                if any(not _is_set(path.rpartition("::")[2], overrides) for path in lacking):
                    self.bag.add(messages.GlobalWithoutValue(symbol.span, symbol.text))
        return self._expressions.values.globals()

    def overrides(self, symbol: TypeSymbol, overrides: Mapping[str, str]) -> tuple[plan.Constraint, ...]:
        """What is set from outside, for the entry scenario and for global parameters."""
        scope = scope_of(symbol, symbol.home)
        return Overrides(self._expressions, scope, self.bag).constraints(overrides)

    def check_values(self, symbol: TypeSymbol, overrides: Mapping[str, str]) -> None:
        """Report fields of the entry scenario that nothing gives a value."""
        values = self._expressions.values
        fields = all_fields(symbol)
        for path in values.lacking_of(symbol, {}):
            if not _is_set(path, overrides):
                self.bag.add(messages.NoValue(fields[path.partition(".")[0]].span, path))


def _is_set(path: str, overrides: Mapping[str, str]) -> bool:
    """Whether a field, or what holds it, is set from outside."""
    return any(path == given or path.startswith(f"{given}.") for given in overrides)
