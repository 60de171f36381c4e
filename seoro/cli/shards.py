"""Parts of all tests, for several machines."""

from __future__ import annotations

import argparse
import hashlib
from typing import NamedTuple


class Shard(NamedTuple):
    """Part of all tests, such as 2 of 5, counted from 1."""

    number: int
    total: int

    @classmethod
    def parse(cls, text: str) -> Shard:
        """Convert a text such as `2/5`.

        Raises:
            ArgumentTypeError: The text is invalid.
        """
        number, slash, count = text.partition("/")
        if slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
            return cls(int(number), int(count))
        raise argparse.ArgumentTypeError(f"expected N/M, such as 2/5, found {text!r}")

    def __str__(self) -> str:
        return f"{self.number}/{self.total}"

    def has(self, test: str) -> bool:
        """Whether a test belongs to this part, which depends on its name alone."""
        digest = hashlib.sha256(test.encode()).digest()
        return int.from_bytes(digest[:8], "big") % self.total == self.number - 1
