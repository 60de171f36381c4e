"""Names in ROS 2: what packages, interfaces, fields and constants may be called."""

from __future__ import annotations

from typing import Final, NamedTuple

PARTS: Final = {  # the kinds of interfaces, and what the sections of their files define
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}


class Name(NamedTuple):
    """The name of a structure, in its parts.

    Args:
        package: The package that defines it.
        kind: `msg`, `srv` or `action`; empty if nobody said.
        base: The message, service or action.
        suffix: Which structure of the service or action, such as `_Request`; else empty.
    """

    package: str
    kind: str
    base: str
    suffix: str

    @property
    def interface(self) -> str:
        """What its package calls the message, the service or the action, such as `msg/Point`."""
        return f"{self.kind}/{self.base}"


def parse_name(text: str) -> Name | None:
    """The parts of a name such as `std_srvs/srv/SetBool_Request` or `std_msgs/String`; None if it is none."""
    package, _, rest = text.partition("/")
    kind, slash, last = rest.rpartition("/")
    base, underscore, suffix = last.partition("_")
    if not is_package_name(package) or not base.isalnum() or (slash and kind not in PARTS):
        return None
    return Name(package, kind, base, underscore + suffix)


def is_package_name(name: str) -> bool:
    """Whether a package or a field may have that name: `like_this`."""
    return name.islower() and name[0].isalpha() and _has_single_underscores(name)


def is_interface_name(name: str) -> bool:
    """Whether a message, a service or an action may have that name: `LikeThis`."""
    return name.isascii() and name.isalnum() and name[0].isupper()


def is_constant_name(name: str) -> bool:
    """Whether a constant may have that name: `LIKE_THIS`."""
    return name.isupper() and name[0].isalpha() and _has_single_underscores(name)


def _has_single_underscores(name: str) -> bool:
    """Whether it is of letters, digits and underscores, none of these last or two in a row."""
    return name.isascii() and all(part.isalnum() for part in name.split("_"))
