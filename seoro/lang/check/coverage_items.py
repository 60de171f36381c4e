"""One item of `cover` or `record`: convert its arguments, with all overrides, to an item of the plan.

Section 7.5 leaves some defaults open. An item of a struct or an actor is sampled at the end of the scenario or
action that holds the value, an item of an action at its end. For a modifier, this is the end of the modified
behavior. A cross accepts only `items`, `event`, `text`, `target` and `disable`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from seoro.lang import ast, plan, symbols
from seoro.lang.check.convert import Typed
from seoro.lang.check.coverage_arguments import ARGUMENTS, Argument, Literals
from seoro.lang.check.coverage_bounds import Bounds, bounds_of, path_of
from seoro.lang.check.coverage_buckets import buckets_of, default_buckets
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.plan_types import units_of
from seoro.lang.check.scopes import Scope
from seoro.lang.check.traversal import inner_first
from seoro.lang.diagnostics import coverage, names
from seoro.lang.diagnostics import events as event_messages
from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.lang.types import BOOL, dimension_of, is_known

CROSS_ARGUMENTS = ("name", "items", "event", "text", "target", "disable")


class Draft(Value):
    """Source of an item, after overrides.

    Args:
        name: Its name.
        kind: `cover` or `record`.
        owner: The type that it belongs to.
        held_by: The field whose `with:` block contains it; None for a member of the type.
        scope: Scope of the declaration.
        arguments: Its arguments.
        span: Its declaration.
    """

    name: ast.Name
    kind: str
    owner: symbols.TypeSymbol
    held_by: symbols.FieldSymbol | None
    scope: Scope
    arguments: Mapping[str, Argument]
    span: Span


class Item(Value):
    """Elaborated draft; an invalid `event` or `plan`, which has been reported, is `None`."""

    draft: Draft
    event: plan.OwnEvent | None
    plan: plan.AnyCoverageItem | None
    is_disabled: bool


class Items:
    """Elaborates items.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._bag = expressions.bag

    def elaborate(self, draft: Draft, before: Mapping[str, Item], places: Mapping[str, Span]) -> Item:
        """Elaborate a draft.

        Args:
            draft: The draft.
            before: Earlier items, which it can combine, by name.
            places: Spans of all items of its type, including later ones.
        """
        event = self._event(draft)
        is_disabled = Literals(draft.arguments, "", self._bag).flag("disable")
        if "items" in draft.arguments:
            return Item(draft, event, self._cross(draft, event, before, places), is_disabled)
        return Item(draft, event, self._single(draft, event), is_disabled)

    # ------------------------------------------------------------ events

    def _event(self, draft: Draft) -> plan.OwnEvent | None:
        """Return the event that samples an item; report an invalid one and return None."""
        argument = draft.arguments.get("event")
        if argument is None:
            return plan.PhaseEvent(None, plan.Phase.END, draft.span)
        if isinstance(argument.value, ast.FieldAccess):
            self._bag.add(coverage.path_of_event, argument.value.span)
            return None
        if not isinstance(argument.value, ast.NameExpression):
            self._bag.add(coverage.invalid_argument_value, argument.value.span, "event", "the name of an event")
            return None
        name, owner = argument.value.name, draft.owner
        events = owner.inventory.events
        declared = self._expressions.lookup.member(argument.scope.space, events, name)
        if declared is not None:
            return plan.DeclaredEvent(declared.name, name.span)
        phases = tuple(symbols.PHASES) if symbols.has_phases(owner) else ()
        if name.namespace is None and name.text in phases:
            return plan.PhaseEvent(None, symbols.PHASES[name.text], name.span)
        if not symbols.is_open(owner) and not self._expressions.program.is_unread(name.text):
            known = (*(event.text for event in events.values()), *phases)
            self._bag.add(event_messages.unknown_event, name.span, name.text, known)
        return None

    # ------------------------------------------------------------ items of one value

    def _single(self, draft: Draft, event: plan.OwnEvent | None) -> plan.CoverageItem | None:
        arguments, name = draft.arguments, draft.name.text
        value = self._value(draft)
        if value is None:
            return None
        unit = self._unit(draft, value.type)
        literals = Literals(arguments, unit.name if unit is not None else "", self._bag)
        buckets: plan.Buckets = plan.Distinct()
        if is_known(value.type):
            program = self._expressions.program
            default = partial(self._default_buckets, draft, value, unit)
            buckets = buckets_of(name, value.type, arguments, literals, program, self._bag, default)
        ignore, illegal = (self._condition(draft, each, value.type) for each in ("ignore", "illegal"))
        self._check_target(draft, draft.kind, "")
        if event is None:
            return None
        return plan.CoverageItem(
            name=name,
            owner=draft.owner.plan_name,
            kind=plan.CoverageKind(draft.kind),
            expression=value.expression,
            it=draft.held_by.name if draft.held_by is not None else None,
            unit=unit,
            event=event,
            buckets=buckets,
            ignore=ignore,
            illegal=illegal,
            target=literals.count("target"),
            text=literals.text("text"),
            span=draft.span,
        )

    def _default_buckets(self, draft: Draft, value: Typed, unit: plan.CoverageUnit | None) -> plan.Buckets:
        """Return the buckets of an item without arguments for them."""
        it = draft.held_by.name if draft.held_by is not None else None
        path = path_of(value.expression, it)
        bounds = Bounds() if path is None else self._bounds(draft.owner, path, it)
        return default_buckets(value.type, bounds, unit)

    def _bounds(self, owner: symbols.TypeSymbol, path: str, it: str | None) -> Bounds:
        """Return the values that the constraints of a type, and of the structs and actors on a path, leave."""
        found = bounds_of(path, self._expressions.values.structure(owner).members, it)
        first, _, rest = path.partition(".")
        field = owner.inventory.fields.get(first)
        if rest and field is not None and isinstance(field.type, symbols.Structured):
            found = found.within(self._bounds(field.type.symbol, rest, None))
        return found

    def _value(self, draft: Draft) -> Typed | None:
        """Return the sampled value; report a missing one and return None."""
        argument = draft.arguments.get("expression")
        expressions = self._expressions
        if argument is not None:
            value = expressions.value(argument.value, argument.scope)
        else:
            field = expressions.lookup.member(draft.scope.space, draft.scope.fields, draft.name)
            if field is None:
                self._report_nothing(draft)
                return None
            value = Typed(plan.Field(field.name, draft.name.span), field.type)
        if isinstance(value.type, symbols.Primitive | symbols.Quantity | symbols.Enumeration | symbols.Unknown):
            return value
        described = expressions.converter.describe(value.type)
        self._bag.add(coverage.not_scalar, value.expression.span, draft.name.text, described)
        return None

    def _report_nothing(self, draft: Draft) -> None:
        if not symbols.is_open(draft.owner) and not self._expressions.program.is_unread(draft.name.text):
            known = tuple(field.text for field in draft.scope.fields.values())
            owner = draft.owner.qualified_name
            self._bag.add(coverage.nothing_to_sample, draft.name.span, draft.name.text, owner, known)

    def _unit(self, draft: Draft, type_: symbols.Type) -> plan.CoverageUnit | None:
        """Return the unit of an item; None if it needs none, or if it is invalid, which is reported."""
        argument = draft.arguments.get("unit")
        described, program = self._expressions.converter.describe(type_), self._expressions.program
        if argument is None:
            if isinstance(type_, symbols.Quantity):
                units = units_of(type_, program)
                self._bag.add(coverage.missing_unit, draft.name.span, draft.name.text, described, units)
            return None
        if not isinstance(argument.value, ast.NameExpression):
            needed = "the name of a unit"
            self._bag.add(
                coverage.invalid_argument_value, argument.value.span, "unit", needed, "such as `m` or `kph`"
            )
            return None
        name = argument.value.name
        unit = program.units.get(name.text)
        if unit is None:
            self._bag.add(names.unknown_unit, name.span, name.text, tuple(program.units))
        elif unit.dimension is not None and is_known(type_):
            if isinstance(type_, symbols.Quantity) and dimension_of(type_) == unit.dimension:
                return plan.CoverageUnit(unit.name, unit.factor, unit.offset)
            fitting = units_of(type_, program)
            self._bag.add(coverage.invalid_unit, name.span, name.text, draft.name.text, described, fitting)
        return None

    def _condition(self, draft: Draft, name: str, type_: symbols.Type) -> plan.Expression | None:
        """Elaborate `ignore` or `illegal`, which may contain the item's value and constants."""
        argument = draft.arguments.get(name)
        if argument is None:
            return None
        item = draft.name.text
        scope = replace(argument.scope, bindings={**argument.scope.bindings, item: type_})
        condition = self._expressions.converted(argument.value, BOOL, scope, f"`{name}`")
        allowed = (item,) if scope.is_it_bound else (item, "it")
        wrong = next((node for node in inner_first(condition) if not _is_constant(node, allowed)), None)
        if wrong is not None:
            self._bag.add(coverage.not_constant, wrong.span, name, item)
        return condition

    def _check_target(self, draft: Draft, kind: str, reason: str) -> None:
        argument = draft.arguments.get("target")
        if argument is not None and plan.CoverageKind(kind) is plan.CoverageKind.RECORD:
            self._bag.add(coverage.target_of_record, argument.place, draft.name.text, reason)

    # ------------------------------------------------------------ items of several values (7.5.4)

    def _cross(
        self,
        draft: Draft,
        event: plan.OwnEvent | None,
        before: Mapping[str, Item],
        places: Mapping[str, Span],
    ) -> plan.CrossItem | None:
        arguments = draft.arguments
        for name in ARGUMENTS:
            if name in arguments and name not in CROSS_ARGUMENTS:
                reason = "belongs to the combined items, not to their combination"
                place = arguments[name].place
                self._bag.add(coverage.excluded_argument, place, name, reason, arguments["items"].place)
        literals = Literals(arguments, "", self._bag)
        combined = [self._combined(draft, name, event, before, places) for name in literals.names("items")]
        found = [item for item in combined if item is not None]
        records = [item for item in found if item.draft.kind == "record"]
        kind = "record" if records else draft.kind
        self._check_target(draft, kind, f" because `{records[0].draft.name.text}` is one" if records else "")
        leaves = [leaf for item in found for leaf in _leaves(item)]
        if event is None or not found or len(found) < len(combined):
            return None
        return plan.CrossItem(
            name=draft.name.text,
            owner=draft.owner.plan_name,
            kind=plan.CoverageKind(kind),
            items=tuple(dict.fromkeys(leaves)),
            event=event,
            target=literals.count("target"),
            text=literals.text("text"),
            span=draft.span,
        )

    def _combined(
        self,
        draft: Draft,
        name: ast.Name,
        event: plan.OwnEvent | None,
        before: Mapping[str, Item],
        places: Mapping[str, Span],
    ) -> Item | None:
        """Return an item to combine with others; report an invalid one and return None."""
        item = before.get(name.text) if name.text != draft.name.text else None
        if item is None and self._expressions.program.is_unread(name.text):
            return None
        if item is None:
            owner, known = draft.owner.qualified_name, tuple(before)
            self._bag.add(coverage.unknown_item, name.span, name.text, owner, known, places.get(name.text))
            return None
        if event is None or item.event is None:
            return None
        own, other = _event_name(event), _event_name(item.event)
        if own != other:
            self._bag.add(coverage.different_event, name.span, name.text, other, own, item.draft.name.span)
            return None
        return item if item.plan is not None else None


def _is_constant(node: plan.Expression, bindings: tuple[str, ...]) -> bool:
    """Return whether a part of an expression depends only on its own parts and the given bindings."""
    if isinstance(node, plan.Binding):
        return node.name in bindings
    of_instance = plan.Field | plan.Labelled | plan.Global | plan.Self | plan.Call | plan.Construct
    return not isinstance(node, of_instance)


def _leaves(item: Item) -> tuple[str, ...]:
    """Return the names of the single-value items of an item."""
    return item.plan.items if isinstance(item.plan, plan.CrossItem) else (item.draft.name.text,)


def _event_name(event: plan.OwnEvent) -> str:
    return event.phase.value if isinstance(event, plan.PhaseEvent) else event.name
