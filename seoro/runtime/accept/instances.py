"""Instances in a trace, with the values of their fields over time."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import ItemsView, Mapping
from dataclasses import dataclass, field

from seoro.lang.plan import Action, Plan, Scenario, behavior_type
from seoro.runtime.accept.history import Node, Record
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Actor, Value


@dataclass(eq=False)
class Present:
    """Record at which expressions are currently evaluated."""

    seq: int = 0


class TimedFields(dict[str, Value]):
    """Fields by name, with their values at a place of the trace; a `dict`, because structs hold one.

    Args:
        present: The place.
    """

    def __init__(self, present: Present) -> None:
        super().__init__()
        self._present = present
        self._changes: dict[str, tuple[list[int], list[Value]]] = {}

    def change(self, name: str, seq: int, value: Value) -> None:
        """Add a change, in the order of the trace."""
        places, values = self._changes.setdefault(name, ([], []))
        places.append(seq)
        values.append(value)

    def __getitem__(self, name: str) -> Value:
        if name in self._changes:
            places, values = self._changes[name]
            index = bisect_left(places, self._present.seq)
            if index > 0:
                return values[index - 1]
        return super().__getitem__(name)

    def items(self) -> ItemsView[str, Value]:  # type: ignore[override] # the view of another dict
        """Return names with values at the present place."""
        return {name: self[name] for name in self}.items()

    def next_change(self, name: str, seq: int) -> int | None:
        """Return the index of the first change of a field at or after a record."""
        places, _ = self._changes.get(name, ([], []))
        index = bisect_left(places, seq)
        return places[index] if index < len(places) else None


@dataclass(eq=False)
class Instance:
    """An invoked scenario or action.

    Args:
        declaration: Its declaration.
        number: Its number in the trace.
        recorded: Its record.
        fields: Its parameters and variables, and the global parameters.
        actor: Actor of the invocation.
        present: Record at which expressions are evaluated.
        plan: The plan.
    """

    declaration: Scenario | Action
    number: int
    recorded: Record
    fields: TimedFields
    actor: Actor | None
    present: Present
    plan: Plan
    labels: dict[str, list[Instance]] = field(default_factory=dict)
    node: Node | None = None  # invoking behavior

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its type and the inherited ones as in `plan.Methods`, nearest first."""
        return (behavior_type(self.declaration.name), *map(behavior_type, self.declaration.bases))

    @property
    def seq(self) -> int:
        """Index of its record."""
        return int(self.recorded["seq"])

    def invoked(self, label: str) -> Instance | None:
        """Return the last invocation under a label at the present record."""
        found = [each for each in self.labels.get(label, ()) if each.seq < self.present.seq]
        return found[-1] if found else None

    @property
    def environment(self) -> Environment:
        """Return the environment of its scope."""
        return Environment(self, self.plan, {"actor": self.actor} if self.actor is not None else {})


@dataclass(frozen=True, eq=False)
class Holder:
    """Modifier, occurrence or modified behavior as an object with fields.

    Args:
        types: Names of its types, nearest first.
        fields: Values by name.
    """

    types: tuple[str, ...]
    fields: Mapping[str, Value]
