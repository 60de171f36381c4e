"""Texts that are stored once, and used by number."""

from __future__ import annotations

from typing import Final

MOST: Final = 200_000  # different texts
LONGEST: Final = 20_000  # [characters]
NONE: Final = -1


class Strings:
    """Table of texts.

    Attributes:
        texts: The texts by number.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._numbers: dict[str, int] = {}

    def number(self, text: object) -> int:
        """Return the number of a text; `NONE` for an empty one, and for texts beyond the limit of the table."""
        if not isinstance(text, str) or not text:
            return NONE
        found = self._numbers.get(text)
        if found is None:
            if len(self.texts) >= MOST:
                return NONE
            found = self._numbers[text] = len(self.texts)
            self.texts.append(text if len(text) <= LONGEST else text[:LONGEST] + "…")
        return found
