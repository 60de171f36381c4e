"""Errors of keys."""

from __future__ import annotations

from seoro.errors import UsageError


class InvalidKeys(UsageError):
    """Keys are missing, incomplete, expired or not valid for the purpose."""
