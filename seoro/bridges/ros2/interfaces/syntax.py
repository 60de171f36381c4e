"""Parser of .msg, .srv and .action files.

The syntax is that of https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html, and otherwise that of
rosidl: a comment begins at the first `#` of a line, even within quotes. Names follow the rules of ROS 2, on which
the generated code of the CDR codec relies.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from seoro.bridges.ros2.interfaces import definitions
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.literals import InvalidLiteral, read_default, read_scalar
from seoro.bridges.ros2.interfaces.names import PARTS, is_constant_name, is_interface_name, is_package_name

MAX_FILE: Final = 1_000_000  # [characters]
MAX_BOUND: Final = 2**32 - 1  # elements of a sequence, or bytes of a string
MAX_ARRAY: Final = 2**20  # elements of a fixed array of numbers
MAX_ARRAY_OF_STRUCTURES: Final = 4096  # the codec has a line of code for each element of such an array


def read_interface(name: str, text: str, origin: str, first_line: int = 1) -> tuple[definitions.Structure, ...]:
    """Return the structures that a file defines: one for a message, two for a service, three for an action.

    Args:
        name: Full name of the interface, such as `std_srvs/srv/SetBool`.
        text: Text of the file.
        origin: File, in error messages.
        first_line: Number of the first line of the text in the file.

    Raises:
        InvalidDefinition: The definition is invalid; the message has the line and the expected text.
    """
    package, kind, _ = name.split("/")
    suffixes = PARTS[kind]
    if len(text) > MAX_FILE:
        raise InvalidDefinition(f"{origin}: {len(text)} characters exceed the limit of {MAX_FILE}")
    sections: list[list[tuple[int, str]]] = [[]]
    for number, line in enumerate(text.splitlines(), first_line):
        if line.rstrip() == "---":
            sections.append([])
        else:
            sections[-1].append((number, line))
    if len(sections) != len(suffixes):
        raise InvalidDefinition(
            f"{origin}: expected {len(suffixes)} part{'s' * (len(suffixes) > 1)} of a .{kind} file, got"
            f" {len(sections)}",
            help=f"lines of `---` separate the parts; expected {len(suffixes) - 1} of them",
        )
    return tuple(
        _Section(package, origin).read(f"{name}{suffix}", lines)
        for suffix, lines in zip(suffixes, sections, strict=True)
    )


class _Section:
    """Parser of the lines of one structure.

    Args:
        package: Package of names without a package.
        origin: File, in error messages.
    """

    def __init__(self, package: str, origin: str) -> None:
        self._package = package
        self._origin = origin
        self._line = 0

    def read(self, name: str, lines: list[tuple[int, str]]) -> definitions.Structure:
        """Parse the structure of a name from numbered lines."""
        fields: list[definitions.Field] = []
        constants: list[definitions.Constant] = []
        names: dict[str, int] = {}
        for number, member in self._members(lines):
            if member.name in names:
                raise self._invalid(f"duplicate name `{member.name}` (first in line {names[member.name]})")
            names[member.name] = number
            if isinstance(member, definitions.Field):
                fields.append(member)
            else:
                constants.append(member)
        return definitions.Structure(name, tuple(fields), tuple(constants), self._origin)

    def _members(
        self, lines: list[tuple[int, str]]
    ) -> Iterator[tuple[int, definitions.Field | definitions.Constant]]:
        for number, line in lines:
            self._line = number
            words = line.replace("\t", " ").partition("#")[0].split(maxsplit=1)
            if not words:
                continue
            if len(words) < 2:
                raise self._invalid(
                    f"`{words[0]}` is a type without a name",
                    "a line is `TYPE NAME`, `TYPE NAME DEFAULT` or `TYPE NAME=VALUE`",
                )
            type_text, rest = words[0], words[1].strip()
            name, is_constant, value = rest.partition("=")
            if is_constant and len(name.split()) == 1:
                yield number, self._constant(type_text, name.strip(), value.strip())
            else:
                yield number, self._field(type_text, rest)

    def _constant(self, type_text: str, name: str, value: str) -> definitions.Constant:
        type_ = self._type(type_text)
        if not isinstance(type_, definitions.Scalar):
            raise self._invalid(
                f"constant `{name}` is of type `{type_text}`", "constants are numbers, bool or string"
            )
        if not is_constant_name(name):
            raise self._invalid(
                f"`{name}` is an invalid constant name", "write it in capitals, such as `MAX_SPEED`"
            )
        if not value and type_.name not in definitions.TEXTS:
            raise self._invalid(f"constant `{name}` has no value")
        return definitions.Constant(name, type_, self._literal(type_, value))

    def _field(self, type_text: str, rest: str) -> definitions.Field:
        type_ = self._type(type_text)
        name, _, default = rest.partition(" ")
        if not is_package_name(name):
            raise self._invalid(
                f"`{name}` is an invalid field name",
                "fields have small letters, digits and single underscores, and begin with a letter",
            )
        default = default.strip()
        if not default:
            return definitions.Field(name, type_, None, self._line)
        try:
            return definitions.Field(name, type_, read_default(type_, default), self._line)
        except InvalidLiteral as error:
            raise self._invalid(f"default of `{name}`: {error}") from None

    def _literal(self, type_: definitions.Scalar, value: str) -> definitions.Literal:
        try:
            return read_scalar(type_, value)
        except InvalidLiteral as error:
            raise self._invalid(str(error)) from None

    def _type(self, text: str) -> definitions.FieldType:
        single, opened, rest = text.partition("[")
        size, closed, behind = rest.partition("]")
        if bool(opened) != bool(closed) or behind:
            raise self._invalid(f"invalid type `{text}`", "arrays are written `int8[]`, `int8[3]` or `int8[<=3]`")
        element = self._element(single, text)
        if not opened:
            return element
        if not size:
            return definitions.Sequence(element)
        has_numbers = isinstance(element, definitions.Scalar) and element.name not in definitions.TEXTS
        most = MAX_ARRAY if has_numbers else MAX_ARRAY_OF_STRUCTURES
        if size.startswith("<="):
            return definitions.Sequence(element, self._number(size[2:], MAX_BOUND, text))
        return definitions.Array(element, self._number(size, most, text))

    def _element(self, text: str, type_text: str) -> definitions.Element:
        base, bounded, most = text.partition("<=")
        if bounded and base not in definitions.TEXTS:
            raise self._invalid(
                f"invalid length of `{type_text}`", "only `string` has one; for arrays it is in brackets: `[<=N]`"
            )
        if base in definitions.PRIMITIVES:
            return definitions.Scalar(base, self._number(most, MAX_BOUND, type_text) if bounded else 0)
        package, slash, name = base.replace("/msg/", "/").rpartition("/")
        if slash and not is_package_name(package):
            raise self._invalid(f"`{package}` is an invalid package name")
        if not is_interface_name(name):
            times = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}
            primitives = ", ".join(sorted(definitions.PRIMITIVES))
            known = f"types are {primitives} and names of messages, alone or in arrays: `int8[3]`"
            valid = f"ROS 2 has `{times[name]}`" if name in times else known
            raise self._invalid(f"invalid type `{type_text}`", valid)
        return definitions.Named(f"{package or self._package}/msg/{name}")

    def _number(self, text: str, most: int, type_text: str) -> int:
        """Return the number of elements or characters of a type."""
        digits = text[:12] if text.isascii() and text.isdecimal() else "0"  # 12 digits are beyond all limits
        if not 0 < int(digits) <= most:
            raise self._invalid(f"invalid size of `{type_text}`", f"expected 1 to {most}")
        return int(digits)

    def _invalid(self, problem: str, expected: str = "") -> InvalidDefinition:
        return InvalidDefinition(f"{self._origin}:{self._line}: {problem}", help=expected)
