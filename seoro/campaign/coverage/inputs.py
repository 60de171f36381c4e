"""Inputs: items whose values parameters of the entry scenario determine. All others are outputs, only observed.

These are items of the entry scenario, and of behaviors that it invokes once, with the arguments of the invocation.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Final

from seoro.campaign.coverage.items import items_in
from seoro.lang import plan as plan_
from seoro.lang.frozen import Value
from seoro.lang.lower.invocations import invoked_name
from seoro.lang.plan import AnyCoverageItem, CoverageItem, Plan
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Composed, Instance, types_of
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Fields

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
    """

    items: Mapping[str, AnyCoverageItem]
    texts: Mapping[str, str]
    arguments: Mapping[str, plan_.Expression] | None = None

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
                for name in _read(item):
                    yield from _leaves(self.arguments[name], None)

    def environment(self, item: CoverageItem, entry: Instance, plan: Plan) -> Environment:
        """Return the environment of an input.

        Args:
            item: The input.
            entry: Instance of the entry scenario.
            plan: The plan.

        Raises:
            EvaluationError: An argument has no value.
        """
        if self.arguments is None:
            return Environment(entry, plan, {} if item.it is None else {"it": entry.fields[item.it]})
        around, fields = Environment(entry, plan), Fields()
        fields.update({name: evaluate(self.arguments[name], around) for name in _read(item)})
        bindings = {} if item.it is None else {"it": fields[item.it]}
        return Environment(Composed("invoked", fields), plan, bindings, scenario=entry)


def groups_of(plan: Plan) -> tuple[Group, ...]:
    """Return the groups of a plan that have items, that of the entry scenario first."""
    entry = plan.scenarios[plan.entry]
    items = items_in(plan, types_of(entry)[::-1])
    texts = {item.name: _text_of(item) for item in _single(items) if _is_input(item, plan)}
    groups = [Group(items, texts)]
    seen = {_key(item) for item in items.values()}
    numbers = Counter(
        invoked_name(each) for scenario in plan.scenarios.values() for each in plan_.invocations_in(scenario.body)
    )
    for invocation in plan_.invocations_in(entry.body):
        name = invoked_name(invocation)
        declared = plan.actions if isinstance(invocation, plan_.InvokeAction) else plan.scenarios
        items = items_in(plan, types_of(declared[name])[::-1])
        if numbers[name] == 1 and items and seen.isdisjoint(map(_key, items.values())):
            arguments = {key: value for key, value in invocation.arguments if _is_pure(value, None, plan)}
            given = (item for item in _single(items) if _is_given(item, arguments))
            groups.append(Group(items, {item.name: _given_text(item, arguments) for item in given}, arguments))
            seen.update(map(_key, items.values()))
    return tuple(groups)


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


def _is_given(item: CoverageItem, arguments: Mapping[str, plan_.Expression]) -> bool:
    """Return whether the arguments of an invocation determine the value of an item of the invoked behavior."""
    nodes = list(plan_.walk(item.expression))
    is_known = all(isinstance(node, _PURE) or _is_it(node, item) for node in nodes)
    has_text = any(isinstance(node, plan_.Literal) and isinstance(node.value, str) for node in nodes)
    return is_known and not has_text and _read(item) <= arguments.keys()


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


def _given_text(item: CoverageItem, arguments: Mapping[str, plan_.Expression]) -> str:
    """Return the value of an item of an invoked behavior, with arguments instead of parameters."""
    names = "|".join(map(re.escape, sorted(_read(item))))
    if not names:
        return _text_of(item)

    def argument(found: re.Match[str]) -> str:
        return _as_operand(" ".join(arguments[found[0]].span.text.split()))

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
