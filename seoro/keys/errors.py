"""What is wrong with keys."""

from __future__ import annotations

from seoro.errors import InvalidUse


class InvalidKeys(InvalidUse):
    """Keys cannot be used: they are not there, not whole, not valid now, or not for this."""
