"""Messages as immutable Python objects, with an attribute for each member."""

from __future__ import annotations

import keyword
from collections import namedtuple
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

from seoro.bridges.ros2.interfaces.definitions import Structure, wire_fields


class Message:
    """A message of ROS 2. Its members are attributes; arrays of numbers are numpy arrays, which may be read-only.

    Constants of its definition are attributes of its class. If the name of a member is a Python keyword, such as
    `from`, its attribute ends with an underscore. Messages of a type are equal if their members are, arrays
    element by element. Instances are tuples of their members; `TypeStore` makes them.
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

    def __ne__(self, other: object) -> bool:  # tuples have one, too
        return not self == other

    __hash__ = None  # type: ignore[assignment] # arrays have none


def _are_equal(one: Any, other: Any) -> bool:
    """Return whether two members are equal; compare numpy arrays without an import of numpy."""
    if hasattr(one, "dtype") and hasattr(other, "dtype"):
        return one.shape == other.shape and bool((one == other).all())
    return bool(one == other)


def attribute(field: str) -> str:
    """Return the name of the attribute of a member."""
    return f"{field}_" if keyword.iskeyword(field) else field


def plain(message: Message) -> dict[str, Any]:
    """Convert a message to dictionaries, lists, numbers and strings, as in YAML and JSON. NaN is kept."""
    return {name: _plain(getattr(message, attribute(name))) for name in message.__members__}


def _plain(value: Any) -> Any:
    if isinstance(value, Message):
        return plain(value)
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value  # a numpy array


def message_class(structure: Structure) -> type[Message]:
    """Return a class for the messages of a structure."""
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
