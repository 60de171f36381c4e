"""Literals in definitions: defaults of fields and values of constants."""

from __future__ import annotations

import re
from typing import Final

from seoro.bridges.ros2.interfaces import definitions

_TRUTH: Final = {"true": True, "1": True, "false": False, "0": False}
_ITEM: Final = r"""\s*(?:("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')\s*(?=,|$)|([^,]*))"""


class InvalidLiteral(Exception):
    """The text is not a value of the type."""


def read_default(type_: definitions.FieldType, text: str) -> definitions.Literal | tuple[definitions.Literal, ...]:
    """Parse the default of a field.

    Raises:
        InvalidLiteral: The text is not a value of the type, or the type has no defaults.
    """
    match type_:
        case definitions.Scalar():
            return read_scalar(type_, text)
        case definitions.Array(element) | definitions.Sequence(element) if isinstance(element, definitions.Scalar):
            values = tuple(read_scalar(element, item) for item in _items(text))
        case _:
            raise InvalidLiteral(f"{type_} cannot have a default")
    if isinstance(type_, definitions.Array) and len(values) != type_.length:
        raise InvalidLiteral(f"expected {type_.length} elements ({type_}), got {len(values)}")
    if isinstance(type_, definitions.Sequence) and 0 < type_.bound < len(values):
        raise InvalidLiteral(f"expected at most {type_.bound} elements ({type_}), got {len(values)}")
    return values


def read_scalar(type_: definitions.Scalar, text: str) -> definitions.Literal:
    """Parse a number, a boolean or a string.

    Raises:
        InvalidLiteral: The text is not a value of the type.
    """
    name = type_.name
    if name == "bool":
        if text.lower() not in _TRUTH:
            raise InvalidLiteral(f"`{text}` is not a bool; expected true or false")
        return _TRUTH[text.lower()]
    if name in definitions.INTEGERS:
        return _integer(name, text)
    if name in definitions.FLOATS:
        try:
            return float(text)
        except ValueError:
            raise InvalidLiteral(f"`{text}` is not a valid {name}") from None
    unquoted = _unquoted(text)
    if 0 < type_.bound < len(unquoted.encode()):
        raise InvalidLiteral(f"{unquoted!r} is longer than {type_}")
    return unquoted


def _integer(name: str, text: str) -> int:
    """Parse an integer, in decimal, or with 0x, 0o or 0b."""
    low, high = definitions.INTEGERS[name]
    digits = text if len(text) < 80 else ""  # Python rejects much longer numbers
    try:
        value = int(digits)
    except ValueError:
        try:
            value = int(digits, 0)
        except ValueError:
            raise InvalidLiteral(f"`{text[:80]}` is not a valid {name}") from None
    if not low <= value <= high:
        raise InvalidLiteral(f"{value} is outside the range of {name}, {low} to {high}")
    return value


def _unquoted(text: str) -> str:
    for quote in ('"', "'"):
        if len(text) > 1 and text.startswith(quote) and text.endswith(quote):
            inner = text[1:-1]
            if re.search(rf"(?<!\\){quote}", inner):
                raise InvalidLiteral(rf"{text} has a {quote} within; write \{quote}")
            return inner.replace(f"\\{quote}", quote)
    return text


def _items(text: str) -> list[str]:
    """Split `[a, b, c]` into elements; commas within quotes do not separate elements."""
    if not (text.startswith("[") and text.endswith("]")):
        raise InvalidLiteral(f"`{text}` is not a list; expected [a, b, c]")
    inner = text[1:-1].strip()
    items: list[str] = []
    item_pattern = re.compile(_ITEM)
    position = 0
    while inner and position <= len(inner):
        found = item_pattern.match(inner, position)
        assert found is not None  # the last alternative matches any text
        item = found[1] or found[2].strip()
        if not item:
            raise InvalidLiteral(f"`{text}` has an empty element")
        items.append(item)
        position = found.end() + 1
    return items
