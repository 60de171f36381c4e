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

# ruff: noqa: I001 - each name once, exported by `as`
from __future__ import annotations

from seoro.lang.plan.behaviors import (
    Behavior as Behavior,
    CallMethod as CallMethod,
    Composition as Composition,
    Emit as Emit,
    Invocation as Invocation,
    InvokeAction as InvokeAction,
    InvokeScenario as InvokeScenario,
    On as On,
    OneOf as OneOf,
    Overlap as Overlap,
    Parallel as Parallel,
    Sample as Sample,
    Serial as Serial,
    Wait as Wait,
)
from seoro.lang.plan.coverage import (
    AnyCoverageItem as AnyCoverageItem,
    Buckets as Buckets,
    Coverage as Coverage,
    CoverageItem as CoverageItem,
    CoverageKind as CoverageKind,
    CoverageUnit as CoverageUnit,
    CrossItem as CrossItem,
    Distinct as Distinct,
    EachValue as EachValue,
    Edges as Edges,
    Levels as Levels,
    Slices as Slices,
)
from seoro.lang.plan.declarations import (
    Action as Action,
    Declaration as Declaration,
    Event as Event,
    Modifier as Modifier,
    ObjectType as ObjectType,
    Plan as Plan,
    Scenario as Scenario,
)
from seoro.lang.plan.events import (
    DeclaredEvent as DeclaredEvent,
    Elapsed as Elapsed,
    EventCondition as EventCondition,
    EventReference as EventReference,
    EventSpecification as EventSpecification,
    Every as Every,
    Fall as Fall,
    Holds as Holds,
    LabelEvent as LabelEvent,
    MemberEvent as MemberEvent,
    OnEvent as OnEvent,
    OwnEvent as OwnEvent,
    Phase as Phase,
    PhaseEvent as PhaseEvent,
    Rise as Rise,
)
from seoro.lang.plan.expressions import (
    Arithmetic as Arithmetic,
    Binding as Binding,
    Bound as Bound,
    Call as Call,
    Cast as Cast,
    Compare as Compare,
    Concatenate as Concatenate,
    Conditional as Conditional,
    Construct as Construct,
    Contains as Contains,
    Convert as Convert,
    Expression as Expression,
    Field as Field,
    ForEach as ForEach,
    Global as Global,
    Index as Index,
    Join as Join,
    Labelled as Labelled,
    ListOf as ListOf,
    Literal as Literal,
    Logic as Logic,
    Member as Member,
    Negate as Negate,
    Not as Not,
    RangeOf as RangeOf,
    Reference as Reference,
    Self as Self,
    Size as Size,
    StringCall as StringCall,
    TypeTest as TypeTest,
    parts as parts,
    walk as walk,
)
from seoro.lang.plan.methods import (
    Argument as Argument,
    External as External,
    Method as Method,
    Methods as Methods,
    Undefined as Undefined,
    behavior_type as behavior_type,
    modifier_type as modifier_type,
)
from seoro.lang.plan.modifications import (
    AppliedModifier as AppliedModifier,
    LabelPath as LabelPath,
    Modification as Modification,
    ModifierApplication as ModifierApplication,
    Override as Override,
    OverrideMode as OverrideMode,
    Until as Until,
)
from seoro.lang.plan.operators import (
    Bulk as Bulk,
    Number as Number,
    Side as Side,
    StringMethod as StringMethod,
)
from seoro.lang.plan.structures import (
    Constraint as Constraint,
    ConstraintMember as ConstraintMember,
    FieldDeclaration as FieldDeclaration,
    Latent as Latent,
    RemoveDefault as RemoveDefault,
    Structure as Structure,
    StructureMember as StructureMember,
    Structures as Structures,
)
from seoro.lang.plan.types import (
    ActorType as ActorType,
    EnumType as EnumType,
    EnumValue as EnumValue,
    ListType as ListType,
    PhysicalType as PhysicalType,
    PrimitiveType as PrimitiveType,
    RangeType as RangeType,
    StructType as StructType,
    ValueType as ValueType,
)
