"""Values that lead to a bin, drawn by the solver with its constraints; or the constraints that exclude it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Final

from seoro.campaign.coverage.bins import Bin, bins_of
from seoro.campaign.coverage.inputs import Group, groups_of
from seoro.campaign.coverage.items import parts_of
from seoro.campaign.space.axes import Axis
from seoro.embed.scenarios import Scenario
from seoro.errors import CONFLICT, UsageError
from seoro.lang import plan as plan_
from seoro.lang.frozen import Value
from seoro.lang.lower.invocations import named_invocations
from seoro.lang.lower.outside import ORIGIN
from seoro.lang.plan import Plan
from seoro.lang.source import Span
from seoro.runtime.coverage.buckets import bucket_of
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.environment import EvaluationError, NoSolution
from seoro.runtime.values.text import value_text
from seoro.runtime.values.values import Actor, Struct
from seoro.runtime.values.values import Value as Held

ATTEMPTS: Final = 10  # draws until invoked scenarios allow the values


class Excluded(Exception):
    """Constraints exclude a bin.

    Args:
        reasons: Their texts, with their places.
    """

    def __init__(self, reasons: tuple[str, ...]) -> None:
        super().__init__(", ".join(reasons))
        self.reasons = reasons


class Drawn(Value):
    """Values that lead to a bin.

    Args:
        values: Values of parameters by path, in the notation of the scenario.
        samples: Qualified items with their buckets, for these values.
    """

    values: Mapping[str, str]
    samples: frozenset[tuple[str, str]]


class InputSpace:
    """Bins of the items over parameters of a scenario, and values for them.

    Args:
        scenario: The loaded scenario.
        name: Name of the entry scenario, or None.
        overrides: Values of parameters that all runs share.
        constraints: Constraints from outside that all runs share.
        axes: Parameters that vary.
        plan: Its plan.
    """

    def __init__(
        self,
        scenario: Scenario,
        name: str | None,
        overrides: Mapping[str, str],
        constraints: Sequence[str],
        axes: Sequence[Axis],
        plan: Plan,
    ) -> None:
        self._scenario = scenario
        self._name = name
        self._overrides = overrides
        self._constraints = constraints
        self._axes = axes
        self._plan = plan

    @cached_property
    def bins(self) -> tuple[Bin, ...]:
        """The bins."""
        return bins_of(self._groups, self._plan)

    @cached_property
    def _groups(self) -> tuple[Group, ...]:
        return groups_of(self._plan, {axis.path for axis in self._axes})

    @cached_property
    def _paths(self) -> tuple[str, ...]:
        """Paths of the parameters that vary or that items depend on."""
        fields = self._plan.scenarios[self._plan.entry].structure.fields
        own = [axis.path for axis in self._axes if axis.path.partition(".")[0] in fields]
        read = (path for group in self._groups for path in group.paths())
        return tuple(dict.fromkeys((*own, *(path for path in read if path not in self._overrides))))

    def draw(self, wanted: Bin, seed: int) -> Drawn:
        """Draw values that lead to a bin.

        Args:
            wanted: The bin.
            seed: Seed of the draw.

        Raises:
            Excluded: Constraints exclude the bin.
            UsageError: A parameter has no bounds, or another expression no value.
        """
        reasons: list[str] = []
        first = seed % len(wanted.ways)  # not always the same invocation, which runs may not reach
        for way in (*wanted.ways[first:], *wanted.ways[:first]):
            try:
                return self._draw(way, seed)
            except Excluded as excluded:
                reasons.extend(excluded.reasons)
        raise Excluded(tuple(dict.fromkeys(reasons)))

    def _draw(self, way: Sequence[str], seed: int) -> Drawn:
        """Draw values that meet the constraints of a way; see `draw` for the exceptions."""
        from seoro.runtime.parameters.parameters import make_entry  # noqa: PLC0415 - loads most of the runtime

        plan = self._scenario.plan(self._name, self._overrides, (*self._constraints, *way))
        reasons: tuple[str, ...] = ()
        for attempt in range(ATTEMPTS):
            try:
                entry, _ = make_entry(plan, seed + attempt)
            except UsageError as error:
                if error.code != CONFLICT:
                    raise
                raise Excluded(tuple(_reasons(error.places, way))) from error
            try:
                chosen = self._chosen(entry, seed + attempt, plan)
            except NoSolution as conflict:
                reasons = tuple(_reasons(conflict.places[:-1], way))
                continue
            texts = {path: _text_at(entry, path, plan) for path in self._paths}
            for group in self._groups:
                fields = plan.invoked(_invocation(group, plan)).structure.fields if group.own else {}
                for name in group.own:
                    text = value_text(chosen[group.invocation][name], fields[name].type, plan.structures)
                    texts[f"{group.invocation}.{name}"] = text
            values = {path: text for path, text in texts.items() if text is not None}
            return Drawn(values, self._samples(entry, chosen, plan))
        raise Excluded(reasons)

    def _chosen(self, entry: Instance, seed: int, plan: Plan) -> Mapping[str, Mapping[str, Held]]:
        """Return the values of varying parameters of invocations, by their names.

        Raises:
            NoSolution: An invocation contradicts the values of the scenario.
        """
        from seoro.runtime.feasibility.conflicts import choose_invoked, find_certain_conflicts  # noqa: PLC0415

        fields = plan.scenarios[plan.entry].structure.fields
        fixed = {path: entry.fields[path] for path in self._paths if path in fields}
        for conflict in find_certain_conflicts(plan, fixed):
            raise conflict
        return {
            group.invocation: choose_invoked(_invocation(group, plan), fixed, plan, seed)
            for group in self._groups
            if group.own
        }

    def _samples(
        self, entry: Instance, chosen: Mapping[str, Mapping[str, Held]], plan: Plan
    ) -> frozenset[tuple[str, str]]:
        found: set[tuple[str, str]] = set()
        for group in self._groups:
            buckets = _buckets(group, entry, chosen.get(group.invocation, {}), plan)
            for item in group.items.values():
                own = [buckets.get(part.name) for part in parts_of(item, group.items)]
                known = [bucket for bucket in own if bucket is not None]
                if len(known) == len(own):
                    found.add((f"{item.owner}.{item.name}", " x ".join(known)))
        return frozenset(found)


def _invocation(group: Group, plan: Plan) -> plan_.InvokeAction | plan_.InvokeScenario:
    return named_invocations(plan.scenarios[plan.entry].body)[group.invocation]


def _buckets(group: Group, entry: Instance, chosen: Mapping[str, Held], plan: Plan) -> Mapping[str, str]:
    """Return the buckets of the items of single values, by name."""
    found: dict[str, str] = {}
    for item in group.inputs:
        try:
            value = evaluate(item.expression, group.environment(item, entry, chosen, plan))
        except EvaluationError:
            continue
        if item.unit is not None and isinstance(value, int | float):
            value = item.unit.of_si(value)
        bucket = bucket_of(item.buckets, value)
        if bucket is not None:
            found[item.name] = bucket
    return found


def _reasons(places: Sequence[tuple[Span, str]], own: Sequence[str]) -> Iterator[str]:
    """Yield the constraints of a conflict, apart from those of the bin."""
    for span, _ in places:
        if span.file.name == ORIGIN and span.file.text in own:
            continue
        text = " ".join(span.text.split())
        yield text if span.file.name == ORIGIN else f"{text} ({span})"


def _text_at(entry: Instance, path: str, plan: Plan) -> str | None:
    """Return the value of a parameter in the notation of the scenario; None for values that cannot be set."""
    first, *rest = path.split(".")
    value: Held = entry.fields[first]
    roots = (plan.scenarios[plan.entry].structure, plan.globals)
    type_ = next((root.fields[first].type for root in roots if first in root.fields), None)
    for name in rest:
        if not isinstance(value, Struct | Actor):
            return None
        structure = plan.structures.find(value.type)
        declared = structure.fields.get(name) if structure is not None else None
        value, type_ = value.fields[name], declared.type if declared is not None else None
    return None if isinstance(value, Actor | Struct) else value_text(value, type_, plan.structures)
