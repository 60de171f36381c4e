"""Registry of structures by name, read on first use."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from seoro.bridges.ros2.interfaces.definitions import (
    SUFFIXES,
    Field,
    Named,
    Structure,
    derive,
    element_of,
    is_sent,
)
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, UnknownInterface, near
from seoro.bridges.ros2.interfaces.names import PARTS, Name, parse_name
from seoro.bridges.ros2.interfaces.packages import Package, Source
from seoro.bridges.ros2.interfaces.syntax import read_interface

MAX_DEPTH: Final = 32  # nesting of structures


class Registry:
    """Registry of the structures of some packages.

    Args:
        packages: The packages by name.
    """

    def __init__(self, packages: Mapping[str, Package]) -> None:
        self.packages = packages
        self._structures: dict[str, Structure] = {}
        self._sound: set[str] = set()

    def names(self) -> tuple[str, ...]:
        """Return the full names of all messages, services and actions, sorted."""
        return tuple(
            f"{package}/{interface}"
            for package in sorted(self.packages)
            for interface in self.packages[package].interfaces()
        )

    def canonical(self, name: str) -> str:
        """Return the full name of an interface, written with dots or slashes, with or without the kind.

        Raises:
            UnknownInterface: No package defines the name, or its kind is ambiguous.
        """
        found = parse_name(name.strip().replace("::", "/").replace(".", "/"))
        if found is None:
            raise UnknownInterface(
                f"{name!r} is an invalid interface name; expected one like `std_msgs/msg/String`",
                help=near(name, self.names(), 0.8),
            )
        kinds = [found.kind] if found.kind else list(PARTS)
        candidates = [
            f"{found.package}/{meant.interface}{found.suffix}"
            for meant in (found._replace(kind=kind) for kind in kinds)
            if found.suffix in SUFFIXES[meant.kind] and self._source(meant) is not None
        ]
        match candidates:
            case [only]:
                return only
            case []:
                raise self._unknown(name, found)
            case _:
                raise UnknownInterface(f"{name!r} is ambiguous", help=f"write {' or '.join(candidates)}")

    def message(self, name: str) -> str:
        """Return the full name of a message, and not of a whole service or action.

        Raises:
            UnknownInterface: The interface is unknown, or is not a message.
        """
        full = self.canonical(name)
        parts = parse_name(full)
        assert parts is not None
        if is_sent(parts.suffix, parts.kind):
            return full
        raise UnknownInterface(
            f"`{full}` is {'a service' if parts.kind == 'srv' or parts.suffix else 'an action'}, not a message",
            help=f"it consists of {_parts(parts.kind, parts.base)}",
        )

    def structure(self, name: str) -> Structure:
        """Return a structure by its full name, after a check of all nested structures.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: The definition is invalid, or refers to an unknown structure.
        """
        structure = self.read(name)
        if name not in self._sound:
            self._check(structure, ())
        return structure

    def read(self, name: str) -> Structure:
        """Return a structure by its full name, without a check of nested structures.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: The definition is invalid.
        """
        known = self._structures.get(name)
        if known is not None:
            return known
        found = parse_name(name)
        source = self._source(found) if found is not None and found.kind else None
        if found is None or source is None or found.suffix not in SUFFIXES[found.kind]:
            return self.read(self.canonical(name))  # raises the error
        interface = f"{found.package}/{found.interface}"
        if found.suffix in PARTS[found.kind]:
            read = read_interface(interface, source.text, source.origin, source.line)
            self._structures |= {structure.name: structure for structure in read}
        else:
            self._structures[name] = derive(interface, found.suffix)
        return self._structures[name]

    def _check(self, structure: Structure, within: tuple[str, ...]) -> None:
        """Check that all nested structures exist, and that none contains itself."""
        if structure.name in self._sound:
            return
        if structure.name in within:
            raise InvalidDefinition(
                f"{structure.origin}: `{structure.name}` contains itself",
                help=" -> ".join((*within, structure.name)),
            )
        if len(within) > MAX_DEPTH:
            raise InvalidDefinition(f"{structure.origin}: more than {MAX_DEPTH} nested structures")
        for field in structure.fields:
            element = element_of(field.type)
            if isinstance(element, Named):
                self._check(self._referenced(structure, field, element.name), (*within, structure.name))
        self._sound.add(structure.name)

    def _referenced(self, structure: Structure, field: Field, name: str) -> Structure:
        try:
            return self.read(name)
        except UnknownInterface as error:
            place = f"{structure.origin}:{field.line}" if field.line else structure.name
            raise InvalidDefinition(f"{place}: unknown type of `{field.name}`: {error}", help=error.help) from None

    def _source(self, name: Name) -> Source | None:
        """Return the source of the definition of a structure."""
        package = self.packages.get(name.package)
        return None if package is None else package.source(name.interface)

    def _unknown(self, written: str, name: Name) -> UnknownInterface:
        wanted = f"{name.package}/{name.kind or 'msg'}/{name.base}"
        package = self.packages.get(name.package)
        if package is None:
            meant = near(name.package, self.packages, 0.8) or near(wanted, self.names(), 0.8)
            return UnknownInterface(
                f"unknown package `{name.package}` of the type `{written}`; known packages: those of seoro and of "
                "the given folders",
                help=f"{meant}; else {_ADD_FOLDER}" if meant else _ADD_FOLDER,
            )
        interfaces = package.interfaces()
        for kind in [name.kind] if name.kind else PARTS:
            if name.suffix and f"{kind}/{name.base}" in interfaces:
                return UnknownInterface(
                    f"`{name.package}/{kind}/{name.base}` has no `{name.suffix}`",
                    help=f"it consists of {_parts(kind, name.base)}",
                )
        return UnknownInterface(
            f"package `{name.package}` has no `{name.interface if name.kind else name.base}`; it is defined by"
            f" {package.origin}",
            help=near(wanted, (f"{name.package}/{interface}" for interface in interfaces)),
        )


_ADD_FOLDER: Final = (
    "give the folder that contains the package, such as `/opt/ros/jazzy/share` or `install/share` of a workspace: "
    "`--interfaces DIR` of `seoro ros`, `--ros-interfaces DIR` of runs, `seoro.Ros(interfaces=[DIR])` of programs"
)


def _parts(kind: str, base: str) -> str:
    """List the messages of an interface, without the package."""
    return ", ".join(f"`{base}{part}`" for part in SUFFIXES[kind] if is_sent(part, kind))
