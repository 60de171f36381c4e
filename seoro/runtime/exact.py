"""Values as the trace tells them exactly: who reads it can tell one instance from another.

JSON knows neither enumerations nor instances. Here each instance of a struct, an actor, a scenario or an action
has a number; its fields are told the first time that it is met in a trace. Numbers start at 0 and follow the
order of telling, so that equal runs have equal numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

from seoro.lang.plan import EnumValue
from seoro.runtime.values import Actor, HasFields, Range, Struct, Value, Variable


@dataclass(eq=False)
class Exact:
    """Numbers instances, and tells values."""

    _numbers: WeakKeyDictionary[object, int] = field(default_factory=WeakKeyDictionary)
    _told: WeakSet[object] = field(default_factory=WeakSet)
    _next: count[int] = field(default_factory=count)

    def number(self, holder: object) -> int:
        """The number of an instance."""
        found = self._numbers.get(holder)
        if found is None:
            found = self._numbers[holder] = next(self._next)
        return found

    def fields(self, fields: Mapping[str, Value]) -> dict[str, Any]:
        """Values by name."""
        return {name: self.value(value) for name, value in fields.items()}

    def value(self, value: Value) -> object:
        """A value, as JSON knows it."""
        match value:
            case EnumValue(type_name, member, number):
                return {"enum": type_name, "member": member, "number": number}
            case Struct() | Actor():
                return self._object(value)
            case Variable(holder=holder, name=name):
                return {"variable": name, "of": self._holder(holder)}
            case Range(low, high):
                return {"low": low, "high": high}
            case float() if not math.isfinite(value):
                return {"float": str(value)}
            case tuple():
                return [self.value(item) for item in value]
            case _:
                return value

    def _object(self, value: Struct | Actor) -> dict[str, Any]:
        if value in self._told:
            return {"object": self.number(value)}
        self._told.add(value)
        told: dict[str, Any] = {"object": self.number(value), "types": list(value.types)}
        if isinstance(value, Actor):
            told["actor"] = value.name
        return {**told, "fields": self.fields(value.fields)}

    def _holder(self, holder: HasFields) -> object:
        return self._object(holder) if isinstance(holder, Struct | Actor) else {"object": self.number(holder)}
