"""What actors are wished to be, which is written like values of parameters: `any:turtlebot4`, `robot:tb1`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

ANY: Final = "any:"
ROBOT: Final = "robot:"


@dataclass(frozen=True)
class Wish:
    """What an actor is to be: any robot of a type or with a capability, or the one of a name."""

    word: str
    is_name: bool


def split_wishes(settings: Mapping[str, str]) -> tuple[dict[str, str], dict[str, Wish]]:
    """Settings of parameters, and wishes for robots."""
    plain, wishes = dict[str, str](), dict[str, Wish]()
    for path, value in settings.items():
        if value.startswith(ANY):
            wishes[path] = Wish(value.removeprefix(ANY).strip(), is_name=False)
        elif value.startswith(ROBOT):
            wishes[path] = Wish(value.removeprefix(ROBOT).strip(), is_name=True)
        else:
            plain[path] = value
    return plain, wishes
