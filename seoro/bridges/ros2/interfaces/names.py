"""Names of packages, interfaces, fields and constants in ROS 2."""

from __future__ import annotations

from typing import Final, NamedTuple

PARTS: Final = {  # suffixes of the structures that a definition file contains, by the kind of the interface
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}


class Name(NamedTuple):
    """Parts of the name of a structure.

    Args:
        package: Package of the interface.
        kind: `msg`, `srv` or `action`; empty if it was not given.
        base: Name of the message, service or action.
        suffix: Suffix of the structure within a service or action, such as `_Request`; else empty.
    """

    package: str
    kind: str
    base: str
    suffix: str

    @property
    def interface(self) -> str:
        """Name of the message, service or action within its package, such as `msg/Point`."""
        return f"{self.kind}/{self.base}"


def parse_name(text: str) -> Name | None:
    """Split a name such as `std_srvs/srv/SetBool_Request` or `std_msgs/String`; return None if it is invalid."""
    package, _, rest = text.partition("/")
    kind, slash, last = rest.rpartition("/")
    base, underscore, suffix = last.partition("_")
    if not is_package_name(package) or not base.isalnum() or (slash and kind not in PARTS):
        return None
    return Name(package, kind, base, underscore + suffix)


def is_package_name(name: str) -> bool:
    """Return whether a name of a package or field is valid: `like_this`."""
    return name.islower() and name[0].isalpha() and _has_single_underscores(name)


def is_interface_name(name: str) -> bool:
    """Return whether a name of a message, service or action is valid: `LikeThis`."""
    return name.isascii() and name.isalnum() and name[0].isupper()


def is_constant_name(name: str) -> bool:
    """Return whether a name of a constant is valid: `LIKE_THIS`."""
    return name.isupper() and name[0].isalpha() and _has_single_underscores(name)


def _has_single_underscores(name: str) -> bool:
    """Return whether a name has letters, digits and single underscores only, and no underscore at the end."""
    return name.isascii() and all(part.isalnum() for part in name.split("_"))
