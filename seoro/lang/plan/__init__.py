"""The plan: what the runtime executes.

It is the only bridge between language and runtime. Everything in it is resolved: names, types, units
(all numbers in SI base units), the bindings of arguments to parameters, where each value comes from.
Every node is frozen and knows its place in the source text.

Values, when the runtime holds them:

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

from __future__ import annotations

from seoro.lang.plan.behaviors import (
    Behavior,
    Emit,
    InvokeAction,
    InvokeScenario,
    OneOf,
    Parallel,
    Serial,
    Wait,
)
from seoro.lang.plan.declarations import (
    Action,
    Event,
    Plan,
    Scenario,
)
from seoro.lang.plan.events import (
    DeclaredEvent,
    Elapsed,
    EventReference,
    EventSpecification,
    OnEvent,
    Phase,
    PhaseEvent,
)
from seoro.lang.plan.expressions import (
    Arithmetic,
    Binding,
    Bound,
    Bulk,
    Call,
    Cast,
    Compare,
    Concatenate,
    Conditional,
    Construct,
    Contains,
    Convert,
    Expression,
    External,
    Field,
    ForEach,
    Global,
    Index,
    Join,
    ListOf,
    Literal,
    Logic,
    Member,
    Method,
    Methods,
    Negate,
    Not,
    Number,
    RangeOf,
    Self,
    Side,
    Size,
    StringCall,
    StringMethod,
    TypeTest,
    Undefined,
    behavior_type,
    parts,
)
from seoro.lang.plan.structures import (
    Constraint,
    ConstraintMember,
    FieldDeclaration,
    Latent,
    RemoveDefault,
    Structure,
    StructureMember,
    Structures,
)
from seoro.lang.plan.types import (
    ActorType,
    EnumType,
    EnumValue,
    ListType,
    PhysicalType,
    PrimitiveType,
    RangeType,
    StructType,
    ValueType,
)

__all__ = [
    "Action",
    "ActorType",
    "Arithmetic",
    "Behavior",
    "Binding",
    "Bound",
    "Bulk",
    "Call",
    "Cast",
    "Compare",
    "Concatenate",
    "Conditional",
    "Constraint",
    "ConstraintMember",
    "Construct",
    "Contains",
    "Convert",
    "DeclaredEvent",
    "Elapsed",
    "Emit",
    "EnumType",
    "EnumValue",
    "Event",
    "EventReference",
    "EventSpecification",
    "Expression",
    "External",
    "Field",
    "FieldDeclaration",
    "ForEach",
    "Global",
    "Index",
    "InvokeAction",
    "InvokeScenario",
    "Join",
    "Latent",
    "ListOf",
    "ListType",
    "Literal",
    "Logic",
    "Member",
    "Method",
    "Methods",
    "Negate",
    "Not",
    "Number",
    "OnEvent",
    "OneOf",
    "Parallel",
    "Phase",
    "PhaseEvent",
    "PhysicalType",
    "Plan",
    "PrimitiveType",
    "RangeOf",
    "RangeType",
    "RemoveDefault",
    "Scenario",
    "Self",
    "Serial",
    "Side",
    "Size",
    "StringCall",
    "StringMethod",
    "StructType",
    "Structure",
    "StructureMember",
    "Structures",
    "TypeTest",
    "Undefined",
    "ValueType",
    "Wait",
    "behavior_type",
    "parts",
]
