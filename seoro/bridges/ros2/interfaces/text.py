"""Definitions as text, in the syntax of .msg files."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from seoro.bridges.ros2.interfaces.definitions import Literal, Named, Structure, element_of

_RULER = "=" * 80


def lines(structure: Structure) -> Iterator[str]:
    """Yield the lines of a definition: constants, then fields."""
    for constant in structure.constants:
        yield f"{constant.type} {constant.name}={_literal(constant.value)}"
    for field in structure.fields:
        if field.default is None:
            yield f"{_short(str(field.type))} {field.name}"
        else:
            default = field.default
            shown = f"[{', '.join(map(_literal, default))}]" if isinstance(default, tuple) else _literal(default)
            yield f"{_short(str(field.type))} {field.name} {shown}"


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
    top, *others = ("".join(f"{line}\n" for line in lines(lookup(known))) for known in names)
    return top + "".join(
        f"{_RULER}\nMSG: {_short(other)}\n{text}" for other, text in zip(names[1:], others, strict=True)
    )


def _short(name: str) -> str:
    """Return the name of a type in a definition, without the kind if it is a message."""
    return name.replace("/msg/", "/")


def _literal(value: Literal) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            escaped = value.replace('"', r"\"")
            return f'"{escaped}"'
        case _:
            return repr(value)
