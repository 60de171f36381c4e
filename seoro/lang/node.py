"""What the nodes of the tree have in common: they are frozen data classes to the type checker, and cheap to load.

The tree has seventy classes, and a frozen dataclass takes almost a millisecond to be defined: half of what a short
scenario takes in all. A node has the fields that its class declares, in that order; two nodes are never equal.
"""

from __future__ import annotations

from typing import Any, NoReturn, dataclass_transform


@dataclass_transform(frozen_default=True, eq_default=False)
class Node:
    """A node of the tree."""

    def __init_subclass__(cls) -> None:
        cls.__match_args__ = tuple(cls.__annotations__)  # type: ignore[misc, attr-defined]

    def __init__(self, *values: Any) -> None:
        self.__dict__.update(zip(self.__match_args__, values, strict=True))  # type: ignore[attr-defined]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} is immutable")

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={value!r}" for name, value in self.__dict__.items() if name != "span")
        return f"{type(self).__name__}({shown})"
