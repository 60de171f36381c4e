"""Definitions as text, in the syntax of .msg files."""

from __future__ import annotations

from collections.abc import Callable

from seoro.bridges.ros2.interfaces.definitions import Literal, Named, Structure, element_of

_RULER = "=" * 80


def definition(structure: Structure) -> str:
    """Return the lines of a definition: constants, then fields."""
    lines = [f"{each.type} {each.name}={_literal(each.value)}\n" for each in structure.constants]
    for field in structure.fields:
        default = "" if field.default is None else f" {_literal(field.default)}"
        lines.append(f"{_short(str(field.type))} {field.name}{default}\n")
    return "".join(lines)


def schema(name: str, lookup: Callable[[str], Structure]) -> str:
    """Return a definition followed by those of all nested structures, in the MCAP encoding `ros2msg`.

    Args:
        name: Full name of the structure.
        lookup: Returns a structure by its full name.
    """
    names = [name]
    for known in names:  # the list grows meanwhile
        elements = [element_of(field.type) for field in lookup(known).fields]
        for element in elements:
            if isinstance(element, Named) and element.name not in names:
                names.append(element.name)
    nested = (f"{_RULER}\nMSG: {_short(other)}\n{definition(lookup(other))}" for other in names[1:])
    return definition(lookup(name)) + "".join(nested)


def _short(name: str) -> str:
    """Return the name of a type in a definition, without the kind if it is a message."""
    return name.replace("/msg/", "/")


def _literal(value: Literal | tuple[Literal, ...]) -> str:
    match value:
        case tuple():
            return f"[{', '.join(map(_literal, value))}]"
        case bool():
            return str(value).lower()
        case str():
            escaped = value.replace('"', r"\"")
            return f'"{escaped}"'
        case _:
            return repr(value)
