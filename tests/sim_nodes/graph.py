"""Compares the objects of two simulations, to find state that a snapshot misses."""

from __future__ import annotations

from collections import deque
from dataclasses import is_dataclass
from enum import Enum
from typing import Any

import numpy as np
from pydantic import BaseModel

from sim_nodes.stateful import Stateful

OURS = "sim_nodes."
ENGINES = ("sim_nodes.mujoco.", "sim_nodes.pybullet.")  # their state is tested by `sim_nodes.check`


def differences(first: object, second: object) -> list[str]:
    """List the differences between two objects and everything that they refer to, one line each."""
    return list(_Comparison().compare(first, second, type(first).__name__))


class _Comparison:
    def __init__(self) -> None:
        self._seen: dict[tuple[int, int], object] = {}  # keeps the object alive, so that its id stays unique

    def compare(self, one: Any, other: Any, where: str) -> list[str]:
        if (id(one), id(other)) in self._seen:
            return []
        self._seen[id(one), id(other)] = (one, other)
        if type(one) is not type(other):
            return [f"{where}: {one!r} and {other!r}"]
        match one:
            case None | bool() | int() | str() | bytes() | Enum() | BaseModel():
                return [] if one == other else [f"{where}: {one!r} and {other!r}"]
            case float():
                return [] if one.hex() == other.hex() else [f"{where}: {one!r} and {other!r}"]
            case np.ndarray():
                return [] if np.array_equal(one, other, equal_nan=True) else [f"{where}: arrays differ"]
            case dict():
                if list(one) != list(other):
                    return [f"{where}: keys {list(one)} and {list(other)}"]
                return [line for key in one for line in self.compare(one[key], other[key], f"{where}[{key!r}]")]
            case set() | frozenset():
                return [] if one == other else [f"{where}: {one} and {other}"]
            case list() | tuple() | deque():
                if len(one) != len(other):
                    return [f"{where}: {len(one)} and {len(other)} elements"]
                pairs = enumerate(zip(one, other, strict=True))
                return [line for index, (a, b) in pairs for line in self.compare(a, b, f"{where}[{index}]")]
            case _:
                return self._compare_objects(one, other, where)

    def _compare_objects(self, one: Any, other: Any, where: str) -> list[str]:
        kind = type(one)
        if not kind.__module__.startswith(OURS) or kind.__module__.startswith(ENGINES) or callable(one):
            return []
        derived = one.DERIVED if isinstance(one, Stateful) else ()
        mine = {name: value for name, value in vars(one).items() if name not in derived}
        theirs = {name: value for name, value in vars(other).items() if name not in derived}
        if is_dataclass(one):  # besides fields, there may be cached properties
            mine = {name: value for name, value in mine.items() if name in theirs}
            theirs = {name: value for name, value in theirs.items() if name in mine}
        return self.compare(mine, theirs, where)
