"""Robot selectors of actors, written like values of parameters: `any:turtlebot4`, `robot:tb1`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from seoro.lang.frozen import Value

ANY: Final = "any:"
ROBOT: Final = "robot:"


class Selector(Value):
    """Selector of an actor's robot: any robot of a type or with a capability, or a robot by name."""

    value: str
    is_name: bool


def split_selectors(settings: Mapping[str, str]) -> tuple[dict[str, str], dict[str, Selector]]:
    """Split settings into those of parameters, and selectors of robots."""
    plain, selectors = dict[str, str](), dict[str, Selector]()
    for path, value in settings.items():
        if value.startswith(ANY):
            selectors[path] = Selector(value.removeprefix(ANY).strip(), is_name=False)
        elif value.startswith(ROBOT):
            selectors[path] = Selector(value.removeprefix(ROBOT).strip(), is_name=True)
        else:
            plain[path] = value
    return plain, selectors
