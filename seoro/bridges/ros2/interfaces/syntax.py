"""Reads .msg, .srv and .action files.

The syntax is that of https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html, and where that is silent
what rosidl reads: a comment begins at the first `#` of a line, even within quotes. Names are held to ROS 2's
rules, on which the generated code of the CDR codec relies.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from seoro.bridges.ros2.interfaces.definitions import (
    PRIMITIVES,
    TEXTS,
    Array,
    Constant,
    Element,
    Field,
    FieldType,
    Literal,
    Named,
    Scalar,
    Sequence,
    Structure,
)
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.literals import InvalidLiteral, read_default, read_scalar

PARTS: Final = {  # what the sections of a file define
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
MAX_FILE: Final = 1_000_000  # [characters]
MAX_ARRAY: Final = 2**24  # elements of a fixed array of numbers
MAX_ARRAY_OF_STRUCTURES: Final = 4096  # the codec has a line of code for each element of such an array

_PACKAGE = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
_INTERFACE = re.compile(r"[A-Z][A-Za-z0-9]*")
_CONSTANT = re.compile(r"[A-Z](?:[A-Z0-9_]?[A-Z0-9]+)*")
_ASSIGNMENT = re.compile(r"([^\s=]+)\s*=\s*(.*)")
_TYPE = re.compile(
    r"(?P<base>[A-Za-z][\w/]*)(?P<bound><=(?P<most>\d+))?(?P<many>\[(?:(?P<upper><=)?(?P<count>\d+))?\])?"
)


def is_package_name(name: str) -> bool:
    """Whether a package may have that name."""
    return _PACKAGE.fullmatch(name) is not None


def is_interface_name(name: str) -> bool:
    """Whether a message, a service or an action may have that name."""
    return _INTERFACE.fullmatch(name) is not None


def read_interface(name: str, text: str, origin: str, first_line: int = 1) -> tuple[Structure, ...]:
    """The structures that a file defines: one for a message, two for a service, three for an action.

    Args:
        name: The full name of the interface, such as `std_srvs/srv/SetBool`.
        text: What the file has.
        origin: The file, for messages.
        first_line: The number of the text's first line in that file.

    Raises:
        InvalidDefinition: The text is no definition; says the line and what was expected.
    """
    package, kind, _ = name.split("/")
    suffixes = PARTS[kind]
    if len(text) > MAX_FILE:
        raise InvalidDefinition(f"{origin}: {len(text)} characters are more than the {MAX_FILE} of the limit")
    sections: list[list[tuple[int, str]]] = [[]]
    for number, line in enumerate(text.splitlines(), first_line):
        if line.rstrip() == "---":
            sections.append([])
        else:
            sections[-1].append((number, line))
    if len(sections) != len(suffixes):
        raise InvalidDefinition(
            f"{origin}: a .{kind} file has {len(suffixes)} part{'s' * (len(suffixes) > 1)}, and this one has"
            f" {len(sections)}",
            help=f"lines of `---` separate the parts; {len(suffixes) - 1} of them were expected",
        )
    return tuple(
        _Section(package, origin).read(f"{name}{suffix}", lines)
        for suffix, lines in zip(suffixes, sections, strict=True)
    )


class _Section:
    """Reads the lines of one structure.

    Args:
        package: Where names without a package are looked up.
        origin: The file, for messages.
    """

    def __init__(self, package: str, origin: str) -> None:
        self._package = package
        self._origin = origin
        self._line = 0

    def read(self, name: str, lines: list[tuple[int, str]]) -> Structure:
        """The structure of that name in these numbered lines."""
        fields: list[Field] = []
        constants: list[Constant] = []
        names: dict[str, int] = {}
        for number, member in self._members(lines):
            if member.name in names:
                raise self._invalid(f"`{member.name}` is defined in line {names[member.name]} already")
            names[member.name] = number
            if isinstance(member, Field):
                fields.append(member)
            else:
                constants.append(member)
        return Structure(name, tuple(fields), tuple(constants), self._origin)

    def _members(self, lines: list[tuple[int, str]]) -> Iterator[tuple[int, Field | Constant]]:
        for number, line in lines:
            self._line = number
            words = line.partition("#")[0].split(maxsplit=1)
            if not words:
                continue
            if len(words) < 2:
                raise self._invalid(
                    f"`{words[0]}` is a type without a name",
                    "a line is `TYPE NAME`, `TYPE NAME DEFAULT` or `TYPE NAME=VALUE`",
                )
            type_text, rest = words[0], words[1].strip()
            assignment = _ASSIGNMENT.fullmatch(rest)
            yield (
                number,
                self._constant(type_text, *assignment.groups()) if assignment else self._field(type_text, rest),
            )

    def _constant(self, type_text: str, name: str, value: str) -> Constant:
        type_ = self._type(type_text)
        if not isinstance(type_, Scalar):
            raise self._invalid(
                f"constant `{name}` is of type `{type_text}`", "constants are numbers, bool or string"
            )
        if not _CONSTANT.fullmatch(name):
            raise self._invalid(f"`{name}` is no name of a constant", "write it in capitals, such as `MAX_SPEED`")
        if not value and type_.name not in TEXTS:
            raise self._invalid(f"constant `{name}` has no value")
        return Constant(name, type_, self._literal(type_, value))

    def _field(self, type_text: str, rest: str) -> Field:
        type_ = self._type(type_text)
        name, _, default = rest.replace("\t", " ").partition(" ")
        if not _PACKAGE.fullmatch(name):
            raise self._invalid(
                f"`{name}` is no name of a field",
                "fields have small letters, digits and single underscores, and begin with a letter",
            )
        default = default.strip()
        if not default:
            return Field(name, type_, None, self._line)
        try:
            return Field(name, type_, read_default(type_, default), self._line)
        except InvalidLiteral as error:
            raise self._invalid(f"default of `{name}`: {error}") from None

    def _literal(self, type_: Scalar, value: str) -> Literal:
        try:
            return read_scalar(type_, value)
        except InvalidLiteral as error:
            raise self._invalid(str(error)) from None

    def _type(self, text: str) -> FieldType:
        found = _TYPE.fullmatch(text)
        if found is None:
            raise self._invalid(
                f"`{text}` is no type",
                "such as `float64`, `string<=10`, `geometry_msgs/Point`, `int32[3]`, `int32[<=3]`",
            )
        element = self._element(found["base"], found["most"])
        if found["many"] is None:
            return element
        if found["count"] is None:
            return Sequence(element)
        count = int(found["count"][:12])  # longer ones are beyond all limits as well
        if found["upper"]:
            if not 0 < count < 2**32:
                raise self._invalid(f"`{text}` may have {count} elements", "a bound is from 1 to 4294967295")
            return Sequence(element, count)
        most = MAX_ARRAY if isinstance(element, Scalar) and element.name not in TEXTS else MAX_ARRAY_OF_STRUCTURES
        if not 0 < count <= most:
            raise self._invalid(f"`{text}` has {count} elements", f"from 1 to {most} are possible")
        return Array(element, count)

    def _element(self, base: str, most: str | None) -> Element:
        if base in PRIMITIVES:
            if most is None:
                return Scalar(base)
            if base not in TEXTS or not 0 < int(most[:12]) < 2**32:
                raise self._invalid(
                    f"`{base}<={most}`",
                    "a length can be given for `string` only, from 1 to 4294967295; for arrays: `[<=N]`",
                )
            return Scalar(base, int(most))
        if most is not None:
            raise self._invalid(f"`{base}<={most}`", "a length can be given for `string` only")
        package, _, name = base.replace("/msg/", "/").rpartition("/")
        if package and not is_package_name(package):
            raise self._invalid(f"`{package}` is no name of a package")
        if not is_interface_name(name):
            times = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}
            meant = (
                f"ROS 2 has `{times[name]}`"
                if name in times
                else f"types are {', '.join(sorted(PRIMITIVES))} and names of messages"
            )
            raise self._invalid(f"`{base}` is no type", meant)
        return Named(f"{package or self._package}/msg/{name}")

    def _invalid(self, problem: str, expected: str = "") -> InvalidDefinition:
        return InvalidDefinition(f"{self._origin}:{self._line}: {problem}", help=expected)
