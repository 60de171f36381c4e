"""Bounds of answers: agents pay for each character."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any, Final

MOST_ITEMS: Final = 50  # of a list or an object
LONGEST_TEXT: Final = 2000  # [characters]
_DEEPEST: Final = 8  # levels
LARGEST: Final = 100_000  # [characters] of the texts of an answer
_MOST_VALUES: Final = 2000  # of an answer


class Bounds:
    """Cuts large values of an answer.

    Attributes:
        cut: Places of the cut values, such as `measurements.robots`.
    """

    def __init__(self) -> None:
        self.cut: list[str] = []
        self._values = 0
        self._characters = 0

    def apply(self, value: Any, place: str) -> Any:
        """Return JSON data with long texts, lists and objects cut.

        Args:
            value: JSON data.
            place: Name of its place in the answer.
        """
        return self._bounded(value, place, 0)

    def _bounded(self, value: Any, place: str, level: int) -> Any:
        self._values += 1
        match value:
            case str():
                return self._text(value, place)
            case dict() | list() | tuple() if level >= _DEEPEST or self._values > _MOST_VALUES:
                self._note(place)
                return f"({len(value)} values left out)"
            case dict():
                return {
                    str(key)[:LONGEST_TEXT]: self._bounded(item, f"{place}.{key}"[:LONGEST_TEXT], level + 1)
                    for key, item in self._first(value.items(), len(value), place)
                }
            case list() | tuple():
                return [self._bounded(item, place, level + 1) for item in self._first(value, len(value), place)]
        return value

    def _text(self, text: str, place: str) -> str:
        most = LONGEST_TEXT if self._characters < LARGEST else 0
        self._characters += min(len(text), most)
        if len(text) <= most:
            return text
        self._note(place)
        return f"{text[:most]}... ({len(text) - most} more characters)"

    def _first(self, items: Any, count: int, place: str) -> Iterator[Any]:
        if count > MOST_ITEMS:
            self._note(f"{place} ({MOST_ITEMS} of {count})")
        return islice(items, MOST_ITEMS)

    def _note(self, place: str) -> None:
        if place not in self.cut and len(self.cut) < MOST_ITEMS:
            self.cut.append(place)
