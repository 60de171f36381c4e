"""Definitions of interfaces: structures with fields and constants.

Services and actions have no classes here: they consist of structures, whose names derive from that of the service
or action. A definition file contains some of them (`_Request`, `_Goal`, ...). The others follow from rules of
rosidl (`rosidl_parser/definition.py`): an action is two services and one message, and every service has an event,
for introspection. Type hashes contain the names of all fields.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, TypeAlias

from seoro.bridges.ros2.interfaces.names import PARTS

# Integer types with their minimum and maximum. `char` and `byte` are numbers from 0 to 255 in ROS 2.
INTEGERS: Final = {
    "byte": (0, 255),
    "char": (0, 255),
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
FLOATS: Final = ("float32", "float64")
TEXTS: Final = ("string", "wstring")
PRIMITIVES: Final = frozenset(("bool", *INTEGERS, *FLOATS, *TEXTS))

Literal: TypeAlias = bool | int | float | str


@dataclass(frozen=True)
class Scalar:
    """A primitive type: a number, a boolean, or a string of at most `bound` bytes (0 for no limit)."""

    name: str
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.name}<={self.bound}" if self.bound else self.name


@dataclass(frozen=True)
class Named:
    """Reference to another structure by its full name."""

    name: str

    def __str__(self) -> str:
        return self.name


Element: TypeAlias = Scalar | Named


@dataclass(frozen=True)
class Array:
    """Array of exactly `length` elements."""

    element: Element
    length: int

    def __str__(self) -> str:
        return f"{self.element}[{self.length}]"


@dataclass(frozen=True)
class Sequence:
    """Sequence of at most `bound` elements (0 for no limit)."""

    element: Element
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.element}[{f'<={self.bound}' if self.bound else ''}]"


FieldType: TypeAlias = Scalar | Named | Array | Sequence


@dataclass(frozen=True)
class Field:
    """A member of a structure.

    Args:
        name: Name in the definition.
        type: Type of the member.
        default: Default in the definition; None for zero or empty.
        line: Line of the definition, from 1; 0 for derived fields.
    """

    name: str
    type: FieldType
    default: Literal | tuple[Literal, ...] | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Constant:
    """A constant, which is not part of messages."""

    name: str
    type: Scalar
    value: Literal


@dataclass(frozen=True)
class Structure:
    """Structure of a message.

    Args:
        name: Full name, such as `geometry_msgs/msg/Point` or `std_srvs/srv/SetBool_Request`.
        fields: Fields in the order of the wire.
        constants: Constants in the order of the definition.
        origin: File of the definition, in error messages.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()
    origin: str = field(default="", compare=False)


# Member of empty structures on the wire and in type hashes, since IDL does not allow empty structures.
FILLER: Final = (Field("structure_needs_at_least_one_member", Scalar("uint8")),)


def wire_fields(structure: Structure) -> tuple[Field, ...]:
    """Return the fields of a structure on the wire."""
    return structure.fields or FILLER


def element_of(type_: FieldType) -> Element:
    """Return the element type of an array or a sequence."""
    return type_.element if isinstance(type_, Array | Sequence) else type_


_SERVICE: Final = ("", "_Request", "_Response", "_Event")
SUFFIXES: Final = {  # suffixes of all structures of an interface, by its kind
    "msg": ("",),
    "srv": _SERVICE,
    "action": (
        "",
        *PARTS["action"],
        *(f"_SendGoal{suffix}" for suffix in _SERVICE),
        *(f"_GetResult{suffix}" for suffix in _SERVICE),
        "_FeedbackMessage",
    ),
}
_GOAL_ID: Final = Field("goal_id", Named("unique_identifier_msgs/msg/UUID"))


def is_sent(suffix: str, kind: str) -> bool:
    """Return whether a structure is a message, and not a whole service or action."""
    return kind == "msg" or suffix not in {"", "_SendGoal", "_GetResult"}


def derive(interface: str, suffix: str) -> Structure:
    """Return a derived structure of a service or an action.

    Args:
        interface: Full name of the service or action, such as `nav2_msgs/action/Spin`.
        suffix: Suffix of the structure, such as `_SendGoal_Request`; one of `SUFFIXES` that is not in a file.
    """
    name = interface + suffix
    if "/action/" in interface and not suffix:
        return Structure(name, _action_fields(interface))
    match suffix:
        case "_SendGoal_Request":
            fields = (_GOAL_ID, Field("goal", Named(f"{interface}_Goal")))
        case "_SendGoal_Response":
            fields = (Field("accepted", Scalar("bool")), Field("stamp", Named("builtin_interfaces/msg/Time")))
        case "_GetResult_Request":
            return Structure(name, (_GOAL_ID,))
        case "_GetResult_Response":
            fields = (Field("status", Scalar("int8")), Field("result", Named(f"{interface}_Result")))
        case "_FeedbackMessage":
            fields = (_GOAL_ID, Field("feedback", Named(f"{interface}_Feedback")))
        case _:
            return Structure(name, _service_fields(name))
    return Structure(name, fields)


def _service_fields(name: str) -> tuple[Field, ...]:
    """Return the fields of a service, or of its event."""
    if name.endswith("_Event"):
        service = name.removesuffix("_Event")
        return (
            Field("info", Named("service_msgs/msg/ServiceEventInfo")),
            Field("request", Sequence(Named(f"{service}_Request"), 1)),
            Field("response", Sequence(Named(f"{service}_Response"), 1)),
        )
    return (
        Field("request_message", Named(f"{name}_Request")),
        Field("response_message", Named(f"{name}_Response")),
        Field("event_message", Named(f"{name}_Event")),
    )


def _action_fields(name: str) -> tuple[Field, ...]:
    """Return the fields of an action, which are only used for its hash."""
    return (
        Field("goal", Named(f"{name}_Goal")),
        Field("result", Named(f"{name}_Result")),
        Field("feedback", Named(f"{name}_Feedback")),
        Field("send_goal_service", Named(f"{name}_SendGoal")),
        Field("get_result_service", Named(f"{name}_GetResult")),
        Field("feedback_message", Named(f"{name}_FeedbackMessage")),
    )
