"""Conversion of plain values to messages; all values are checked, and missing members get their defaults.

A mapping becomes a structure, a list becomes an array, and numbers, booleans and strings become scalars. Types are
not converted into each other, except integers where a float is expected. Errors have the path of the member.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NoReturn

from seoro.bridges.ros2.interfaces import converters, definitions
from seoro.bridges.ros2.interfaces.errors import InvalidValue, near
from seoro.bridges.ros2.interfaces.messages import Message, attribute


class Builder:
    """Builder of messages from plain values.

    Args:
        lookup: Returns a structure by its full name.
        class_of: Returns the message class of a structure by its full name.

    Attributes:
        converter: Returns a converter to messages of a structure.
    """

    def __init__(
        self, lookup: Callable[[str], definitions.Structure], class_of: Callable[[str], type[Message]]
    ) -> None:
        self.converter = cache(lambda name: _StructureConverter(lookup(name), class_of(name), self))

    def build(self, name: str, value: Mapping[str, Any] | Message) -> Message:
        """Build a message.

        Args:
            name: Full name of the structure.
            value: Members; missing ones get their defaults.

        Raises:
            InvalidValue: A member is unknown or does not fit; the message has its path.
        """
        try:
            return self.converter(name)(value)
        except converters.Mismatch as mismatch:
            raise InvalidValue(name, mismatch.path, str(mismatch), mismatch.help) from None


class _StructureConverter:
    """Converter of mappings and messages to messages of one structure.

    Args:
        structure: The structure.
        cls: Class of its messages.
        builder: Builder of nested structures.
    """

    def __init__(self, structure: definitions.Structure, cls: Callable[..., Message], builder: Builder) -> None:
        self._name = structure.name
        self._cls = cls
        self._members = tuple(
            (field.name, attribute(field.name), _converter(field.type, builder), _default(field, builder))
            for field in structure.fields
        )
        self._names = frozenset(field.name for field in structure.fields)
        defaults = [default for _, _, _, default in self._members]
        self.default: Message = self._cls(*defaults) if defaults else self._cls(0)

    def __call__(self, value: Any) -> Message:
        if isinstance(value, Message):
            if value.__msgtype__ != self._name:
                raise converters.mismatch_of(f"a {self._name}", value)
            return self._made({name: getattr(value, attribute_) for name, attribute_, _, _ in self._members})
        if not isinstance(value, Mapping):
            raise converters.mismatch_of(f"a {self._name}", value, f"write a mapping; {self._list()}")
        if not value.keys() <= self._names:
            self._refuse_unknown(value)
        return self._made(value)

    def _made(self, value: Mapping[str, Any]) -> Message:
        if not value:
            return self.default
        made: list[Any] = []
        try:
            for name, _, convert, default in self._members:
                made.append(convert(value[name]) if name in value else default)
        except converters.Mismatch as mismatch:
            mismatch.within(self._members[len(made)][0])
            raise
        return self._cls(*made)

    def _refuse_unknown(self, value: Mapping[Any, Any]) -> NoReturn:
        unknown = next(name for name in value if name not in self._names)
        raise converters.Mismatch(
            f"unknown member `{unknown}` of {self._name}", near(str(unknown), self._names) or self._list()
        )

    def _list(self) -> str:
        members = ", ".join(f"`{name}`" for name, *_ in self._members)
        return f"its members are {members}" if members else "it has no members"


def _default(field: definitions.Field, builder: Builder) -> Any:
    """Return the default of a member: that of the definition, or else zero or empty."""
    convert = _converter(field.type, builder)
    if field.default is not None:
        return convert(field.default)
    match field.type:
        case definitions.Array(element, length):
            return convert([_zero(element, builder)] * length)
        case definitions.Sequence():
            return convert(())
        case definitions.Scalar() | definitions.Named() as element:
            return _zero(element, builder)


def _zero(element: definitions.Element, builder: Builder) -> Any:
    match element:
        case definitions.Named(name):
            return builder.converter(name).default
        case definitions.Scalar("bool"):
            return False
        case definitions.Scalar("string"):
            return ""
        case definitions.Scalar(name):
            return 0.0 if name in definitions.FLOATS else 0


def _converter(type_: definitions.FieldType, builder: Builder) -> converters.Convert:
    """Return a converter to a type."""
    match type_:
        case definitions.Named(name):
            return builder.converter(name)
        case definitions.Scalar():
            return converters.scalar_converter(type_)
        case definitions.Array(element) | definitions.Sequence(element):
            if isinstance(element, definitions.Scalar) and element.name != "string":
                return converters.array_converter(type_, element)
            return converters.list_converter(type_, _converter(element, builder))
