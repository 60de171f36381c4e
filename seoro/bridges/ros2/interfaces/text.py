"""Definitions as text, in the syntax of .msg files."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from seoro.bridges.ros2.interfaces.definitions import (
    Array,
    Element,
    FieldType,
    Literal,
    Named,
    Scalar,
    Sequence,
    Structure,
    element_of,
)

_RULER = "=" * 80


def lines(structure: Structure) -> Iterator[str]:
    """The lines of a definition: constants, then fields."""
    for constant in structure.constants:
        yield f"{constant.type} {constant.name}={_literal(constant.value)}"
    for field in structure.fields:
        if field.default is None:
            yield f"{_type(field.type)} {field.name}"
        else:
            default = field.default
            shown = f"[{', '.join(map(_literal, default))}]" if isinstance(default, tuple) else _literal(default)
            yield f"{_type(field.type)} {field.name} {shown}"


def schema(name: str, lookup: Callable[[str], Structure]) -> str:
    """A definition followed by all that it refers to, as MCAP has it under the encoding `ros2msg`.

    Args:
        name: The full name of the structure.
        lookup: Gives structures by their full names.
    """
    names = [name]
    for known in names:  # which grows on the way
        elements = [element_of(field.type) for field in lookup(known).fields]
        for element in elements:
            if isinstance(element, Named) and element.name not in names:
                names.append(element.name)
    top, *others = ("".join(f"{line}\n" for line in lines(lookup(known))) for known in names)
    return top + "".join(
        f"{_RULER}\nMSG: {_short(other)}\n{text}" for other, text in zip(names[1:], others, strict=True)
    )


def _type(type_: FieldType) -> str:
    match type_:
        case Array(element, length):
            return f"{_element(element)}[{length}]"
        case Sequence(element, bound):
            return f"{_element(element)}[{f'<={bound}' if bound else ''}]"
        case Scalar() | Named():
            return _element(type_)


def _element(element: Element) -> str:
    return _short(element.name) if isinstance(element, Named) else str(element)


def _short(name: str) -> str:
    """The name of a structure as fields have it: without the kind, if it is a message."""
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
