"""The one exception for requests that cannot be carried out."""

from __future__ import annotations

from collections.abc import Iterable


class RequestRefused(Exception):
    """A request is refused.

    Args:
        code: A result code of `seoro.bridges.wire`.
        message: A sentence that says what is wrong and what would be right.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = int(code)
        self.message = message


def listed(names: Iterable[str]) -> str:
    """Names for a message, sorted; the first twenty of them."""
    known = sorted(names)
    shown = ", ".join(known[:20]) or "none"
    return shown if len(known) <= 20 else f"{shown} and {len(known) - 20} more"
