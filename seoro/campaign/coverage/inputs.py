"""Inputs: items whose values parameters of the entry scenario determine. All others are outputs, only observed.

These are items of the entry scenario, and of behaviors that it invokes, with the arguments of the invocations and
the parameters of invocations that vary. If several invocations have samples of an item, each must determine its
value.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Set
from dataclasses import replace
from typing import Final

from seoro.campaign.coverage.items import items_in
from seoro.lang import plan as plan_
from seoro.lang.frozen import Value
from seoro.lang.lower.invocations import named_invocations
from seoro.lang.plan import AnyCoverageItem, CoverageItem, Plan
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Composed, Instance, types_of
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Fields
from seoro.runtime.values.values import Value as Held

_PURE: Final = (
    plan_.Arithmetic, plan_.Bound, plan_.Compare, plan_.Conditional, plan_.Contains, plan_.Convert, plan_.Field,
    plan_.Global, plan_.Index, plan_.ListOf, plan_.Literal, plan_.Logic, plan_.Member, plan_.Negate, plan_.Not,
    plan_.RangeOf, plan_.Size,
)  # fmt: skip # expressions whose values parameters determine


class Group(Value):
    """Items of the entry scenario, or of a behavior that it invokes.

    Args:
        items: All its items by name.
        texts: Values of its inputs by name, as expressions of the language in the scope of the entry scenario.
        arguments: Arguments of the invoked behavior; None for the entry scenario.
        invocation: Name of the invocation; empty for the entry scenario.
        own: Parameters of the invocation that vary, without an argument.
    """

    items: Mapping[str, AnyCoverageItem]
    texts: Mapping[str, str]
    arguments: Mapping[str, plan_.Expression] | None = None
    invocation: str = ""
    own: frozenset[str] = frozenset()

    @property
    def inputs(self) -> Iterator[CoverageItem]:
        """Its inputs."""
        return (item for name, item in self.items.items() if name in self.texts and isinstance(item, CoverageItem))

    def paths(self) -> Iterator[str]:
        """Yield the paths of the parameters of the entry scenario that its inputs depend on."""
        for item in self.inputs:
            if self.arguments is None:
                yield from _leaves(item.expression, item.it)
            else:
                for name in _read(item) - self.own:
                    yield from _leaves(self.arguments[name], None)

    def environment(
        self, item: CoverageItem, entry: Instance, chosen: Mapping[str, Held], plan: Plan
    ) -> Environment:
        """Return the environment of an input.

        Args:
            item: The input.
            entry: Instance of the entry scenario.
            chosen: Values of the parameters of the invocation that vary.
            plan: The plan.

        Raises:
            EvaluationError: An argument has no value.
        """
        if self.arguments is None:
            return Environment(entry, plan, {} if item.it is None else {"it": entry.fields[item.it]})
        around, fields = Environment(entry, plan), Fields()
        for name in _read(item):
            fields[name] = chosen[name] if name in self.own else evaluate(self.arguments[name], around)
        bindings = {} if item.it is None else {"it": fields[item.it]}
        return Environment(Composed("invoked", fields), plan, bindings, scenario=entry)


def groups_of(plan: Plan, varied: Collection[str]) -> tuple[Group, ...]:
    """Return the groups of a plan that have items, that of the entry scenario first.

    Args:
        plan: The plan.
        varied: Paths of the parameters that vary.
    """
    entry = plan.scenarios[plan.entry]
    items = items_in(plan, types_of(entry)[::-1])
    texts = {item.name: _text_of(item) for item in _single(items) if _is_input(item, plan)}
    groups = [Group(items, texts)]
    for name, invocation in named_invocations(entry.body).items():
        items = items_in(plan, types_of(plan.invoked(invocation))[::-1])
        if items:
            groups.append(_group(name, invocation, items, varied, plan))
    outputs = {_key(item) for group in groups for item in group.items.values() if item.name not in group.texts}
    for scenario in plan.scenarios.values():
        for invocation in plan_.invocations_in(scenario.body) if scenario is not entry else ():
            outputs.update(map(_key, items_in(plan, types_of(plan.invoked(invocation))).values()))
    return tuple(_without(group, outputs) for group in groups)


def _group(
    name: str,
    invocation: plan_.InvokeAction | plan_.InvokeScenario,
    items: Mapping[str, AnyCoverageItem],
    varied: Collection[str],
    plan: Plan,
) -> Group:
    passed = {key for key, _ in invocation.arguments}
    arguments = {key: value for key, value in invocation.arguments if _is_pure(value, None, plan)}
    fields = plan.invoked(invocation).structure.fields
    own = frozenset(key for key in fields if f"{name}.{key}" in varied and key not in passed)
    known = arguments.keys() | own
    given = (item for item in _single(items) if _is_given(item, known))
    texts = {item.name: _given_text(item, arguments, name) for item in given}
    return Group(items, texts, arguments, name, own)


def _without(group: Group, outputs: Collection[tuple[str, str]]) -> Group:
    """Leave out inputs that are outputs elsewhere."""
    kept = {name: text for name, text in group.texts.items() if _key(group.items[name]) not in outputs}
    return replace(group, texts=kept)


def _key(item: AnyCoverageItem) -> tuple[str, str]:
    return item.owner, item.name


def _single(items: Mapping[str, AnyCoverageItem]) -> Iterator[CoverageItem]:
    return (item for item in items.values() if isinstance(item, CoverageItem))


def _is_input(item: CoverageItem, plan: Plan) -> bool:
    """Return whether parameters determine the value of an item of the entry scenario."""
    return _is_pure(item.expression, item.it, plan)


def _is_pure(expression: plan_.Expression, it: str | None, plan: Plan) -> bool:
    for node in plan_.walk(expression):
        is_it = it is not None and isinstance(node, plan_.Binding) and node.name == "it"
        if not (isinstance(node, _PURE) or is_it):
            return False
        if isinstance(node, plan_.Field | plan_.Member) and _is_variable(node, it, plan):
            return False
    return True


def _is_given(item: CoverageItem, known: Set[str]) -> bool:
    """Return whether known parameters of an invocation determine the value of an item of the invoked behavior."""
    nodes = list(plan_.walk(item.expression))
    is_known = all(isinstance(node, _PURE) or _is_it(node, item) for node in nodes)
    has_text = any(isinstance(node, plan_.Literal) and isinstance(node.value, str) for node in nodes)
    return is_known and not has_text and _read(item) <= known


def _is_it(node: plan_.Expression, item: CoverageItem) -> bool:
    return item.it is not None and isinstance(node, plan_.Binding) and node.name == "it"


def _read(item: CoverageItem) -> set[str]:
    """Return the names of the fields that an item reads."""
    nodes = list(plan_.walk(item.expression))
    found = {node.name for node in nodes if isinstance(node, plan_.Field)}
    return found | {item.it for node in nodes if item.it is not None and _is_it(node, item)}


def _text_of(item: CoverageItem) -> str:
    text = " ".join(item.expression.span.text.split())
    return _as_operand(text if item.it is None else re.sub(r"\bit\b", item.it, text))


def _given_text(item: CoverageItem, arguments: Mapping[str, plan_.Expression], invocation: str) -> str:
    """Return the value of an item of an invoked behavior, with arguments or paths instead of parameters."""
    names = "|".join(map(re.escape, sorted(_read(item))))
    if not names:
        return _text_of(item)

    def argument(found: re.Match[str]) -> str:
        given = arguments.get(found[0])
        return f"{invocation}.{found[0]}" if given is None else _as_operand(" ".join(given.span.text.split()))

    return _as_operand(re.sub(rf"(?<![\w.])(?:{names})\b", argument, _text_of(item)))


def _as_operand(text: str) -> str:
    return text if re.fullmatch(r"[\w.]+", text) else f"({text})"


def _is_variable(node: plan_.Field | plan_.Member, it: str | None, plan: Plan) -> bool:
    """Return whether a field is a variable, as far as its type is known."""
    fields = plan.scenarios[plan.entry].structure.fields
    first, *rest = (path_of(node, it) or "").split(".")
    if first not in fields:
        return False
    field = fields[first]
    for name in rest:
        if field.is_variable or not isinstance(field.type, plan_.StructType | plan_.ActorType):
            break
        structure = plan.structures.find(field.type)
        if structure is None or name not in structure.fields:
            break
        field = structure.fields[name]
    return field.is_variable


def path_of(node: plan_.Expression, it: str | None) -> str | None:
    """Return the path of a parameter; None for other expressions.

    Args:
        node: The expression.
        it: Field that `it` denotes; None if it is the instance.
    """
    match node:
        case plan_.Field(name) | plan_.Global(name):
            return name
        case plan_.Binding("it"):
            return it
        case plan_.Member(base, name):
            around = path_of(base, it)
            return None if around is None else f"{around}.{name}"
        case _:
            return None


def _leaves(node: plan_.Expression, it: str | None) -> Iterator[str]:
    """Yield the paths of the parameters that an expression reads."""
    path = path_of(node, it)
    if path is not None:
        yield path
    else:
        for part in plan_.parts(node):
            yield from _leaves(part, it)
