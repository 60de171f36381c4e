"""Error of the formatter."""

from __future__ import annotations

from seoro.errors import SeoroError


class LayoutFault(SeoroError):
    """A valid text cannot be formatted and stays unchanged."""
