"""Sanitising of foreign texts for terminals and logs: no control sequences, no forged lines.

Names, reasons and messages come from clients, robots and scenarios. Use these functions wherever one of them is
printed.
"""

from __future__ import annotations


def printable(text: str) -> str:
    """Replace control characters except line breaks and tabs."""
    return text if text.isprintable() else "".join(c if c.isprintable() or c in "\n\t" else "\ufffd" for c in text)


def one_line(text: str) -> str:
    """Replace control characters, line breaks and tabs, for tables and logs."""
    return text if text.isprintable() else " ".join(printable(text).split())
