"""Outlines of plans, to compare plans with their shared nodes."""

from __future__ import annotations

from enum import Enum
from typing import Any

from seoro.lang.plan import Methods, Structures
from seoro.lang.source import SourceFile


def outline(root: object) -> list[object]:
    """List the classes, references and plain values of everything below a value; shared nodes have one number."""
    numbers: dict[object, int] = {}
    found: list[object] = []
    waiting = [root]
    while waiting:
        value = waiting.pop()
        if value is None or isinstance(value, bool | int | float | str | Enum | SourceFile):
            found.append((type(value).__name__, value.name if isinstance(value, SourceFile) else repr(value)))
            continue
        if id(value) in numbers:
            found.append(numbers[id(value)])
            continue
        numbers[id(value)] = len(numbers)
        parts = parts_of(value)
        found.append((type(value).__name__, len(parts)))
        waiting += parts
    return found


def parts_of(value: Any) -> list[object]:
    """List the values that a node refers to."""
    match value:
        case tuple():
            return list(value)
        case frozenset():
            return sorted(value)
        case dict():
            return [part for item in value.items() for part in item]
        case Structures():
            return list(value.all())
        case Methods():
            return [part for (type_, name), method in value.items() for part in (type_, name, method)]
    return [getattr(value, name) for name in value.__match_args__]
