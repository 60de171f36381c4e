"""Messages as Python sees them: immutable, with an attribute for each member."""

from __future__ import annotations

import keyword
from collections import namedtuple
from typing import TYPE_CHECKING, Any, ClassVar

from seoro.bridges.ros2.interfaces.definitions import Structure, wire_fields


class Message:
    """A message of ROS 2. Its members are attributes; arrays of numbers are numpy arrays, which may be read-only.

    Constants of its definition are attributes of its class. Where a member is a word of Python, such as `from`,
    its attribute has an underscore in the end. Instances are tuples of their members; `TypeStore` makes them.
    """

    __slots__ = ()
    __msgtype__: ClassVar[str]
    __members__: ClassVar[tuple[str, ...]]  # as the definition names them

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


def attribute(field: str) -> str:
    """The attribute that has a member of that name."""
    return f"{field}_" if keyword.iskeyword(field) else field


def message_class(structure: Structure) -> type[Message]:
    """The class of the messages of a structure."""
    fields = wire_fields(structure)
    name = structure.name.rpartition("/")[2]
    members = namedtuple(name, [attribute(field.name) for field in fields])  # type: ignore[misc]
    namespace: dict[str, Any] = {constant.name: constant.value for constant in structure.constants}
    namespace |= {
        "__slots__": (),
        "__msgtype__": structure.name,
        "__members__": tuple(field.name for field in structure.fields),
        "__doc__": f"A {structure.name}.",
    }
    return type(name, (members, Message), namespace)
