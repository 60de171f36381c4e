"""What the formatter raises where it will not format."""

from __future__ import annotations

from seoro.errors import SeoroError


class LayoutFault(SeoroError):
    """A text without errors that cannot be formatted: it is left as it is."""
