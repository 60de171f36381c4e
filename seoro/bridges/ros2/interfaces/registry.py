"""Structures by name, read when they are asked for."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from seoro.bridges.ros2.interfaces.definitions import Field, Named, Structure, element_of
from seoro.bridges.ros2.interfaces.derived import SUFFIXES, derive
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, UnknownInterface, near
from seoro.bridges.ros2.interfaces.packages import Package
from seoro.bridges.ros2.interfaces.syntax import PARTS, read_interface

MAX_DEPTH: Final = 32  # structures within structures

_NAME = re.compile(r"(?P<package>\w+)(?:/(?P<kind>msg|srv|action))?/(?P<base>[^\W_]+)(?P<suffix>_\w+)?")


class Registry:
    """All structures of some packages.

    Args:
        packages: The packages by name.
    """

    def __init__(self, packages: Mapping[str, Package]) -> None:
        self.packages = packages
        self._structures: dict[str, Structure] = {}
        self._sound: set[str] = set()

    def names(self) -> tuple[str, ...]:
        """The full names of all messages, services and actions, sorted."""
        return tuple(
            f"{package}/{interface}"
            for package in sorted(self.packages)
            for interface in self.packages[package].interfaces()
        )

    def canonical(self, name: str) -> str:
        """The full name of what people write with dots or slashes, with or without the kind.

        Raises:
            UnknownInterface: No package defines it, or several kinds have it.
        """
        found = _NAME.fullmatch(name.strip().replace("::", "/").replace(".", "/"))
        if found is None:
            raise UnknownInterface(
                f"{name!r} is no name of an interface, such as `std_msgs/msg/String` or `std_srvs/srv/Trigger`",
                help=near(name, self.names(), 0.8),
            )
        package, kind, base, suffix = found["package"], found["kind"], found["base"], found["suffix"] or ""
        kinds = [kind] if kind else list(PARTS)
        candidates = [
            f"{package}/{kind}/{base}{suffix}"
            for kind in kinds
            if suffix in SUFFIXES[kind] and self._defines(package, f"{kind}/{base}")
        ]
        match candidates:
            case [only]:
                return only
            case []:
                raise self._unknown(name, package, kind, base, suffix)
            case _:
                raise UnknownInterface(f"{name!r} has several meanings", help=f"write {' or '.join(candidates)}")

    def structure(self, name: str) -> Structure:
        """A structure by its full name; all that it refers to exists.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: Its definition cannot be read, or refers to what there is not.
        """
        structure = self.read(name)
        if name not in self._sound:
            self._check(structure, ())
        return structure

    def read(self, name: str) -> Structure:
        """A structure by its full name, whatever it refers to.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: Its definition cannot be read.
        """
        known = self._structures.get(name)
        if known is not None:
            return known
        found = _NAME.fullmatch(name)
        if found is None or found["kind"] is None:
            return self.read(self.canonical(name))
        package, kind, base, suffix = found["package"], found["kind"], found["base"], found["suffix"] or ""
        source = self.packages[package].source(f"{kind}/{base}") if package in self.packages else None
        if source is None or suffix not in SUFFIXES[kind]:
            raise self._unknown(name, package, kind, base, suffix)
        interface = f"{package}/{kind}/{base}"
        if suffix in PARTS[kind]:
            read = read_interface(interface, source.text, source.origin, source.line)
            self._structures |= {structure.name: structure for structure in read}
        else:
            self._structures[name] = derive(interface, suffix)
        return self._structures[name]

    def _check(self, structure: Structure, within: tuple[str, ...]) -> None:
        """Find out whether all exists that a structure refers to, and whether it ends somewhere."""
        if structure.name in self._sound:
            return
        if structure.name in within:
            raise InvalidDefinition(
                f"{structure.origin}: `{structure.name}` contains itself",
                help=" -> ".join((*within, structure.name)),
            )
        if len(within) > MAX_DEPTH:
            raise InvalidDefinition(f"{structure.origin}: more than {MAX_DEPTH} structures within each other")
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
            raise InvalidDefinition(
                f"{place}: `{field.name}` is of an unknown type: {error}", help=error.help
            ) from None

    def _defines(self, package: str, interface: str) -> bool:
        return package in self.packages and self.packages[package].source(interface) is not None

    def _unknown(self, name: str, package: str, kind: str | None, base: str, suffix: str) -> UnknownInterface:
        if package not in self.packages:
            return UnknownInterface(
                f"no package `{package}` of interfaces is known, which `{name}` is of",
                help=near(package, self.packages, 0.8)
                or near(f"{package}/{kind or 'msg'}/{base}", self.names(), 0.8)
                or "add the folder that has the package",
            )
        interfaces = self.packages[package].interfaces()
        for known in PARTS if kind is None else (kind,):
            if suffix and f"{known}/{base}" in interfaces:
                parts = ", ".join(f"`{base}{part}`" for part in SUFFIXES[known] if part) or "no parts"
                return UnknownInterface(f"`{package}/{known}/{base}` has no `{suffix}`", help=f"it has {parts}")
        return UnknownInterface(
            f"package `{package}` has no `{f'{kind}/' if kind else ''}{base}`; it is defined by"
            f" {self.packages[package].origin}",
            help=near(f"{package}/{kind or 'msg'}/{base}", (f"{package}/{interface}" for interface in interfaces)),
        )
