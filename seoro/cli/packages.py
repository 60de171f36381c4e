"""Check for the packages of an extra, before a command needs them."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

from seoro.errors import UsageError

ROS2: Final = ("mcap", "rosbags", "xxhash")


def require(user: str, extra: str, *packages: str) -> None:
    """Check that packages are installed.

    Args:
        user: Subject of the message, such as a command.
        extra: Name of the extra of seoro with the packages.
        packages: Names of modules.

    Raises:
        UsageError: A package is missing.
    """
    for package in packages:
        if find_spec(package) is None:
            raise UsageError(f"{user} needs the package {package}", help=f"pip install 'seoro[{extra}]'")
