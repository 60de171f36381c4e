"""Sampling of `cover` and `record` (7.5): when an item's event occurs, its value goes to the trace and is counted.

It only looks on: a sample is taken between rounds, when the occurrence takes hold; it starts and ends nothing.
Where 7.5 is silent:

- A struct or an actor is sampled when the scenario or action ends that first held it, wherever else it is passed.
- A value that cannot be computed, or is not a number, is an error value, which 7.5.5 ignores; the log warns of it.
- What is ignored leaves no record; what is illegal leaves one that says so, and is in no bucket.
- A combination is sampled when all its items were, and none was ignored or illegal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang import frozen, plan
from seoro.lang.source import Span
from seoro.runtime.buckets import bucket_of, number_of
from seoro.runtime.environment import Environment, EvaluationError, Seed
from seoro.runtime.evaluate import evaluate
from seoro.runtime.holding import newly_held
from seoro.runtime.instantiate import types_of
from seoro.runtime.method_context import MethodContext
from seoro.runtime.tally import ItemCoverage, Tally
from seoro.runtime.trace import Trace
from seoro.runtime.values import Actor, HasFields, Struct, Value, plain

if TYPE_CHECKING:
    from seoro.runtime.instances import Instance

Observe: TypeAlias = Callable[[HasFields, plan.OwnEvent, Callable[[], None]], None]

_DIGITS = 12  # of values in their unit, so that 50kph are 50 again


class _Holder(frozen.Value):
    """Something with items: a scenario, an action or a modifier, or a struct or an actor that it holds.

    Args:
        instance: The scenario, action or modifier.
        value: What has the items.
        path: Where the instance has it; empty for the instance itself.
        seed: What is drawn for values that its items construct is drawn from it.
        run: For external methods that ask for it.
    """

    instance: Instance
    value: Instance | Struct | Actor
    path: str
    seed: Seed
    run: MethodContext

    @property
    def types(self) -> tuple[str, ...]:
        """What `Plan.coverage` calls its types, the most general first."""
        if isinstance(self.value, Struct | Actor):
            return self.value.types[::-1]
        return types_of(self.value.declaration)[::-1]

    def source_of(self, event: plan.OwnEvent) -> Instance | Struct | Actor:
        """Whose event it is: its own if it declares it; `start`, `end` and `fail` are those of the instance."""
        return self.value if isinstance(event, plan.DeclaredEvent) else self.instance

    def path_of(self, event: plan.OwnEvent) -> str:
        """What people call the event at which an item is sampled."""
        if isinstance(event, plan.DeclaredEvent) and self.value is not self.instance:
            return f"{self.instance.path}.{self.path}.{event.name}"
        return self.instance.event(event).path

    def environment(self, bindings: Mapping[str, Value | HasFields]) -> Environment:
        """What names stand for in its items."""
        instance = self.instance
        given = {**bindings, **(instance.bindings if self.value is instance else {})}
        scenario = instance.around or instance
        return Environment(self.value, given, instance.path, scenario, seed=self.seed, run=self.run)


class _Sample(frozen.Value):
    """A value that counts: in the item's unit, and its bucket."""

    value: Value
    bucket: str | None


@dataclass(eq=False)
class Coverage:
    """Samples the items of a run.

    Args:
        items: What is sampled, by type. trace: Where records go. run: For external methods that ask for it,
        apart from that of the scenarios: what items draw changes nothing else.
    """

    items: plan.Coverage
    trace: Trace
    run: MethodContext
    _tallies: dict[tuple[str, str], Tally] = field(default_factory=dict)
    _held: set[Struct | Actor] = field(default_factory=set)

    def results(self) -> tuple[ItemCoverage, ...]:
        """What was sampled of the items of all that was instantiated."""
        return tuple(tally.result() for tally in self._tallies.values())

    def concerns(self, instance: Instance) -> bool:
        """Whether an instance, or what it holds that no other has held before, has items."""
        if not self.items:
            return False
        pending: list[Value] = list(instance.fields.values())
        seen = set(self._held)
        if any(type_ in self.items for type_ in types_of(instance.declaration)):
            return True
        while pending:
            value = pending.pop()
            if isinstance(value, tuple):
                pending += value
            elif isinstance(value, Struct | Actor) and value not in seen:
                seen.add(value)
                if any(type_ in self.items for type_ in value.types):
                    return True
                pending += value.fields.values()
        return False

    def watch(self, instance: Instance, observe: Observe) -> None:
        """Sample the items of a scenario or an action, and of what it holds, from now on.

        Args:
            instance: The instance.
            observe: Is given whose event it is, the event, and what to call with each occurrence.
        """
        if not self.items:
            return
        for holder in self._holders(instance):
            groups: dict[str, tuple[plan.OwnEvent, list[plan.AnyCoverageItem]]] = {}
            for item in self._items_of(holder):
                self._open_tally(holder, item)
                groups.setdefault(holder.path_of(item.event), (item.event, []))[1].append(item)
            for path, (event, items) in groups.items():
                observe(holder.source_of(event), event, partial(self._sample, holder, items, path))

    def _items_of(self, holder: _Holder) -> Iterator[plan.AnyCoverageItem]:
        """Its items, those that are combined before their combinations."""
        for type_ in holder.types:
            yield from self.items.get(type_, ())

    def _holders(self, instance: Instance) -> Iterator[_Holder]:
        """An instance and what it holds that no other has held before."""
        seed = Seed(self.run.seed, f"{instance.path} coverage")
        yield _Holder(instance, instance, "", seed, self.run)
        for value, path in newly_held(instance, self._held):
            yield _Holder(instance, value, path, seed, self.run)

    def _open_tally(self, holder: _Holder, item: plan.AnyCoverageItem) -> None:
        key = item.owner, item.name
        if key in self._tallies:
            return
        if isinstance(item, plan.CoverageItem):
            self._tallies[key] = Tally(item, self._goals(holder, item))
            return
        totals = [self._tally(holder, name).total for name in item.items]
        known = [total for total in totals if total is not None]
        self._tallies[key] = Tally(item, math.prod(known) if len(known) == len(totals) else None)

    def _goals(self, holder: _Holder, item: plan.CoverageItem) -> int | None:
        """How many buckets an item has, apart from those of single values that are ignored or illegal."""
        if not isinstance(item.buckets, plan.EachValue):
            return number_of(item.buckets)
        wanted = [value for value in item.buckets.values if not self._excluded(holder, item, value)]
        return len(wanted)

    def _excluded(self, holder: _Holder, item: plan.CoverageItem, value: Value) -> bool:
        """Whether a value is one that no run is to reach; without an answer, it is not."""
        try:
            return any(self._is_true(holder, item, condition, value) for condition in (item.ignore, item.illegal))
        except EvaluationError:
            return False

    @staticmethod
    def _is_true(
        holder: _Holder, item: plan.CoverageItem, condition: plan.Expression | None, value: Value
    ) -> bool:
        return condition is not None and bool(evaluate(condition, holder.environment({item.name: value})))

    def _tally(self, holder: _Holder, name: str) -> Tally:
        """The tally of another item of a type or what it inherits."""
        owner = next(item.owner for item in self._items_of(holder) if item.name == name)
        return self._tallies[owner, name]

    # ------------------------------------------------------------ samples

    def _sample(self, holder: _Holder, items: list[plan.AnyCoverageItem], event: str) -> None:
        """Sample the items of one event."""
        samples: dict[str, _Sample] = {}
        for item in items:
            if isinstance(item, plan.CrossItem):
                self._sample_cross(holder, item, samples, event)
                continue
            try:
                sample = self._sample_value(holder, item, event)
            except EvaluationError as error:
                self._warn(holder, item, str(error), error.span)
                continue
            if sample is not None:
                samples[item.name] = sample

    def _sample_value(self, holder: _Holder, item: plan.CoverageItem, event: str) -> _Sample | None:
        """The sample of an item; None if it does not count."""
        bindings = {"it": holder.value.fields[item.it]} if item.it is not None else {}
        value = evaluate(item.expression, holder.environment(bindings))
        if isinstance(value, float) and math.isnan(value):
            self._warn(holder, item, "it is not a number", item.span)
            return None
        tally = self._tallies[item.owner, item.name]
        if self._is_true(holder, item, item.ignore, value):
            tally.ignored += 1
            return None
        is_illegal = self._is_true(holder, item, item.illegal, value)
        shown = _in_unit(value, item.unit)
        unit = item.unit.name if item.unit is not None else ""
        self._record(holder, item, event, value=plain(shown), unit=unit, illegal=is_illegal)
        if is_illegal:
            tally.illegal += 1
            return None
        sample = _Sample(shown, bucket_of(item.buckets, shown))
        tally.count(sample.bucket)
        return sample

    def _sample_cross(
        self, holder: _Holder, item: plan.CrossItem, samples: Mapping[str, _Sample], event: str
    ) -> None:
        parts = {name: samples[name] for name in item.items if name in samples}
        if len(parts) < len(item.items):
            return
        values = {name: plain(part.value) for name, part in parts.items()}
        self._record(holder, item, event, value=values, unit="", illegal=False)
        buckets = [part.bucket for part in parts.values()]
        known = [bucket for bucket in buckets if bucket is not None]
        combined = " x ".join(known) if len(known) == len(buckets) else None
        self._tallies[item.owner, item.name].count(combined)

    def _record(self, holder: _Holder, item: plan.AnyCoverageItem, event: str, **fields: object) -> None:
        self.trace.record(item.kind.value, item=_path(holder, item), event=event, **fields)

    def _warn(self, holder: _Holder, item: plan.AnyCoverageItem, reason: str, span: Span) -> None:
        message = f"item `{_path(holder, item)}` has no value: {reason}"
        self.trace.log(message, "warning", span)


def _path(holder: _Holder, item: plan.AnyCoverageItem) -> str:
    return f"{holder.path}.{item.name}" if holder.path else item.name


def _in_unit(value: Value, unit: plan.CoverageUnit | None) -> Value:
    """A physical value in a unit; any other as it is."""
    if unit is None:
        return value
    assert isinstance(value, int | float), "checked: only physical values have a unit"
    return float(f"{(value - unit.offset) / unit.factor:.{_DIGITS}g}")
