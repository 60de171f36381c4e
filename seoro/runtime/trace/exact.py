"""Exact values in the trace: they identify instances, also equal ones.

JSON has neither enumerations nor references. Each instance of a struct, an actor, a scenario or an action has a
number here; its fields are written where it first occurs in a trace. Numbers start at 0 in that order, so that
equal runs have equal numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from itertools import count
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

from seoro.lang.lazy_dataclass import lazy_dataclass
from seoro.lang.plan import EnumValue
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value, Variable


@lazy_dataclass
class Exact:
    """Numbers instances, and encodes values."""

    _numbers: WeakKeyDictionary[object, int] = field(default_factory=WeakKeyDictionary)
    _written: WeakSet[object] = field(default_factory=WeakSet)
    _next: count[int] = field(default_factory=count)

    def number(self, holder: object) -> int:
        """Return the number of an instance."""
        found = self._numbers.get(holder)
        if found is None:
            found = self._numbers[holder] = next(self._next)
        return found

    def fields(self, fields: Mapping[str, Value]) -> dict[str, Any]:
        """Encode values by name."""
        return {name: self.value(value) for name, value in fields.items()}

    def value(self, value: Value) -> object:
        """Encode a value for JSON."""
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
        if value in self._written:
            return {"object": self.number(value)}
        self._written.add(value)
        encoded: dict[str, Any] = {"object": self.number(value), "types": list(value.types)}
        if isinstance(value, Actor):
            encoded["actor"] = value.name
        return {**encoded, "fields": self.fields(value.fields)}

    def _holder(self, holder: HasFields) -> object:
        return self._object(holder) if isinstance(holder, Struct | Actor) else {"object": self.number(holder)}
