"""Width of the terminal."""

from __future__ import annotations

import os
import sys

_FALLBACK = 80


def terminal_columns() -> int:
    """Return the columns of the terminal, without the slow import of `shutil.get_terminal_size`."""
    chosen = os.environ.get("COLUMNS", "")
    if chosen.isdecimal() and int(chosen) > 0:
        return int(chosen)
    if sys.__stdout__ is None:
        return _FALLBACK
    try:
        return os.get_terminal_size(sys.__stdout__.fileno()).columns or _FALLBACK
    except (OSError, ValueError):  # closed, or not a terminal
        return _FALLBACK
