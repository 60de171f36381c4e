"""Recordings of runs for Foxglove and other tools that read MCAP, made from traces; needs `foxglove-sdk`."""

from importlib.util import find_spec
from typing import Final

PACKAGE: Final = "foxglove"


def is_foxglove_installed() -> bool:
    """Return whether recordings can be written."""
    return find_spec(PACKAGE) is not None
