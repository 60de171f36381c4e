"""The plan: what the runtime executes.

It is the only bridge between language and runtime. Names, types, units (all numbers are in SI base units),
bindings of arguments and sources of values are resolved. Every node is frozen and has its span.

Representation of values in the runtime:

| type                     | Python                                     |
|--------------------------|--------------------------------------------|
| bool, int, uint, string  | bool, int, int, str                        |
| float and physical types | float (physical: SI base unit of the type) |
| enumerations             | `EnumValue`                                |
| structs                  | the runtime's instance of a `StructType`   |
| actors                   | the runtime's instance of an `ActorType`   |
| list of T                | tuple                                      |
| range of T               | the runtime's `Range` (low, high)          |
"""

# ruff: noqa: F403 - all classes of the plan in one place
from __future__ import annotations

from seoro.lang.plan.behaviors import *
from seoro.lang.plan.coverage import *
from seoro.lang.plan.declarations import *
from seoro.lang.plan.events import *
from seoro.lang.plan.expressions import *
from seoro.lang.plan.methods import *
from seoro.lang.plan.modifications import *
from seoro.lang.plan.structures import *
from seoro.lang.plan.types import *
