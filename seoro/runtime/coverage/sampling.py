"""Sampling of `cover` and `record` items (7.5): at its event, the value of an item is recorded and counted.

It does not affect the run: samples are taken at commit, between delta cycles. Where 7.5 is silent:

- A struct or an actor is sampled when the scenario or action ends that first held it.
- A value that cannot be computed, or is not a number, is an error value, which 7.5.5 ignores; it is logged as a
  warning.
- Ignored values leave no record; illegal values leave a marked record, and are in no bucket.
- A cross is sampled when all its items were sampled, and none was ignored or illegal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from seoro.deferred import dataclass
from seoro.lang import frozen, plan
from seoro.lang.plan import Plan
from seoro.lang.source import Span
from seoro.runtime.coverage.buckets import Tally, bucket_of, buckets_with, number_of
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import newly_held, types_of
from seoro.runtime.trace.records import Trace
from seoro.runtime.values.environment import Environment, EvaluationError, MethodContext, Seed
from seoro.runtime.values.values import Actor, HasFields, Struct, Value, plain
from seoro.runtime.verdict import ItemCoverage

if TYPE_CHECKING:
    from seoro.runtime.instances.instances import Instance

Observe: TypeAlias = Callable[[HasFields, plan.OwnEvent, Callable[[], None]], None]


class _Holder(frozen.Value):
    """Holder of items: a scenario, an action, a modifier, or an object that it holds.

    Args:
        instance: The scenario, action or modifier.
        value: Object with the items.
        path: Path of the object in the instance; empty for the instance itself.
        run_plan: The plan.
        seed: Seed for values that its items construct.
        run: The run, for external methods.
    """

    instance: Instance
    value: Instance | Struct | Actor
    path: str
    run_plan: Plan
    seed: Seed
    run: MethodContext

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its types as in `Plan.coverage`, the most general first."""
        if isinstance(self.value, Struct | Actor):
            return self.value.types[::-1]
        return types_of(self.value.declaration)[::-1]

    def source_of(self, event: plan.OwnEvent) -> Instance | Struct | Actor:
        """Return the source of an event: its declaring object; the instance for `start`, `end` and `fail`."""
        return self.value if isinstance(event, plan.DeclaredEvent) else self.instance

    def path_of(self, event: plan.OwnEvent) -> str:
        """Return the trace name of the event of an item."""
        if isinstance(event, plan.DeclaredEvent) and self.value is not self.instance:
            return f"{self.instance.path}.{self.path}.{event.name}"
        return self.instance.event_path(event)

    def environment(self, bindings: Mapping[str, Value | HasFields]) -> Environment:
        """Return the environment of its items."""
        instance = self.instance
        given = {**bindings, **(instance.bindings if self.value is instance else {})}
        scenario = instance.around or instance
        return Environment(self.value, self.run_plan, given, instance.path, scenario, seed=self.seed, run=self.run)


class _Sample(frozen.Value):
    """A counted value in the item's unit, with its bucket."""

    value: Value
    bucket: str | None


@dataclass(eq=False)
class Coverage:
    """Samples the items of a run.

    Args:
        run_plan: The plan.
        trace: Receiver of the records.
        run: The run as seen by external methods of items, separate from that of scenarios: random draws of items
            affect nothing else.
    """

    run_plan: Plan
    trace: Trace
    run: MethodContext
    _tallies: dict[tuple[str, str], Tally] = field(default_factory=dict)
    _held: set[Struct | Actor] = field(default_factory=set)

    def results(self) -> tuple[ItemCoverage, ...]:
        """Return the results of all instantiated items."""
        return tuple(tally.result() for tally in self._tallies.values())

    def concerns(self, instance: Instance) -> bool:
        """Whether an instance, or an object that it is the first to hold, has items."""
        if any(type_ in self.run_plan.coverage for type_ in types_of(instance.declaration)):
            return True
        held = newly_held(instance, set(self._held))
        return any(type_ in self.run_plan.coverage for value, _ in held for type_ in value.types)

    def watch(self, instance: Instance, observe: Observe) -> None:
        """Start sampling the items of an instance and of its objects.

        Args:
            instance: The instance.
            observe: Called with the source, the event, and the function to call for each occurrence.
        """
        for holder in self._holders(instance):
            groups: dict[str, tuple[plan.OwnEvent, list[plan.AnyCoverageItem]]] = {}
            for item in self._items_of(holder):
                self._open_tally(holder, item)
                groups.setdefault(holder.path_of(item.event), (item.event, []))[1].append(item)
            for path, (event, items) in groups.items():
                observe(holder.source_of(event), event, partial(self._sample, holder, items, path))

    def _items_of(self, holder: _Holder) -> Iterator[plan.AnyCoverageItem]:
        """Yield its items, crosses after their parts."""
        for type_ in holder.types:
            yield from self.run_plan.coverage.get(type_, ())

    def _holders(self, instance: Instance) -> Iterator[_Holder]:
        """Yield the holders of an instance: itself and the objects that it is the first to hold."""
        seed = Seed(self.run.seed, f"{instance.path} coverage")
        yield _Holder(instance, instance, "", self.run_plan, seed, self.run)
        for value, path in newly_held(instance, self._held):
            yield _Holder(instance, value, path, self.run_plan, seed, self.run)

    def _open_tally(self, holder: _Holder, item: plan.AnyCoverageItem) -> None:
        key = item.owner, item.name
        if key in self._tallies:
            return
        if isinstance(item, plan.CoverageItem):
            self._tallies[key] = Tally(item, number_of(buckets_with(item, self.run_plan)))
            return
        totals = [self._tally(holder, name).total for name in item.items]
        known = [total for total in totals if total is not None]
        self._tallies[key] = Tally(item, math.prod(known) if len(known) == len(totals) else None)

    @staticmethod
    def _is_true(
        holder: _Holder, item: plan.CoverageItem, condition: plan.Expression | None, value: Value
    ) -> bool:
        return condition is not None and bool(evaluate(condition, holder.environment({item.name: value})))

    def _tally(self, holder: _Holder, name: str) -> Tally:
        """Return the tally of another item of a type or of its base types."""
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
        """Sample an item; return None if the sample does not count."""
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
    """Convert a physical value to a unit; return others unchanged."""
    if unit is None:
        return value
    assert isinstance(value, int | float), "checked: only physical values have a unit"
    return unit.of_si(value)
