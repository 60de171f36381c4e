"""What the process of a run elsewhere has printed, in lines, as it comes."""

from __future__ import annotations

import codecs
from typing import Final

LONGEST: Final = 100_000  # [characters] of a line, which is then cut


class PrintedLines:
    """Puts parts together to lines."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._rest = ""

    def add(self, data: bytes) -> None:
        """Take a part."""
        self._rest += self._decoder.decode(data)

    def take(self, *, is_end: bool = False) -> list[str]:
        """The lines that are whole; at the end also one that is not."""
        *lines, self._rest = self._rest.split("\n")
        if self._rest and (is_end or len(self._rest) > LONGEST):
            lines.append(self._rest)
            self._rest = ""
        return [line.rstrip("\r") for line in lines]
