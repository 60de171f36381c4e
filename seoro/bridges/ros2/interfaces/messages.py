"""Messages as Python sees them: immutable, with an attribute for each member."""

from __future__ import annotations

import keyword
from collections import namedtuple
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

from seoro.bridges.ros2.interfaces.definitions import Structure, wire_fields


class Message:
    """A message of ROS 2. Its members are attributes; arrays of numbers are numpy arrays, which may be read-only.

    Constants of its definition are attributes of its class. Where a member is a word of Python, such as `from`,
    its attribute has an underscore in the end. Messages of a type are equal if their members are, arrays element
    by element. Instances are tuples of their members; `TypeStore` makes them.
    """

    __slots__ = ()
    __msgtype__: ClassVar[str]
    __members__: ClassVar[tuple[str, ...]]  # as the definition names them

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

        def __iter__(self) -> Iterator[Any]: ...

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message) or other.__msgtype__ != self.__msgtype__:
            return False
        return all(map(_are_equal, self, other))

    def __ne__(self, other: object) -> bool:  # since tuples have one
        return not self == other

    __hash__ = None  # type: ignore[assignment] # arrays have none


def _are_equal(one: Any, other: Any) -> bool:
    """Whether two members are; arrays of numpy are compared without an import of it."""
    if hasattr(one, "dtype") and hasattr(other, "dtype"):
        return one.shape == other.shape and bool((one == other).all())
    return bool(one == other)


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
    return type(name, (Message, members), namespace)
