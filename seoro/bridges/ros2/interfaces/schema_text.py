"""Definitions in bags: a message with all nested ones in one text, the MCAP encoding `ros2msg`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.names import is_interface_name, parse_name
from seoro.bridges.ros2.interfaces.packages import Package, Source, remote_package

MAX_STRUCTURES: Final = 4096
_RULER: Final = re.compile(r"^={40,}\n", re.MULTILINE)
_HEAD: Final = "MSG: "
KIND: Final = "msg"


def schema_packages(name: str, text: str, packages: Mapping[str, Package], origin: str) -> dict[str, Package]:
    """Return the packages of the messages in a text, which replace those of the same name.

    Args:
        name: Full name of the first message, such as `my_robot/msg/Status`.
        text: Its definition, then one for each nested message, with its name.
        packages: Known packages by name, with the other definitions.
        origin: Origin of the text, in error messages.

    Raises:
        InvalidDefinition: The text is invalid.
    """
    first, *rest = _RULER.split(text.replace("\r\n", "\n"))
    if len(rest) >= MAX_STRUCTURES:
        raise InvalidDefinition(f"{origin}: more than {MAX_STRUCTURES} messages in the definition of {name}")
    found: dict[str, dict[str, Source]] = {}
    _add(found, name, first, origin)
    for section in rest:
        head, _, body = section.partition("\n")
        if not head.startswith(_HEAD):
            raise InvalidDefinition(
                f"{origin}: invalid definition of {name}: expected `{_HEAD}NAME`, found {head!r}"
            )
        _add(found, head.removeprefix(_HEAD).strip(), body, origin)
    return {package: remote_package(each, packages.get(package), origin) for package, each in found.items()}


def _add(found: dict[str, dict[str, Source]], name: str, text: str, origin: str) -> None:
    parsed = parse_name(name)
    if parsed is None or parsed.kind not in ("", KIND) or parsed.suffix or not is_interface_name(parsed.base):
        raise InvalidDefinition(f"{origin}: `{name}` is not the name of a message")
    found.setdefault(parsed.package, {})[f"{KIND}/{parsed.base}"] = Source(text, f"{origin}, {name}")
