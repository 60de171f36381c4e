"""Terminals: colours, columns, and errors with source lines. Commands that run nothing load only this."""

from __future__ import annotations

import os
import sys
from typing import IO, TYPE_CHECKING

from seoro.errors import BackendUnreachable, InvalidScenario, UsageError
from seoro.text.printable import printable

if TYPE_CHECKING:
    from seoro.lang.diagnostic import Diagnostic

_FALLBACK = 80  # columns


def use_colour(file: IO[str]) -> bool:
    """Return whether output to a file is coloured: on terminals, or always with `FORCE_COLOR`.

    `NO_COLOR` comes before `FORCE_COLOR` and `CLICOLOR_FORCE`, as in Python itself.
    """
    if os.environ.get("NO_COLOR"):
        return False
    forced = os.environ.get("FORCE_COLOR") or os.environ.get("CLICOLOR_FORCE") or "0"
    return forced != "0" or is_terminal(file)


def is_terminal(file: IO[str]) -> bool:
    """Return whether a file is a terminal with control sequences."""
    return file.isatty() and os.environ.get("TERM") != "dumb"


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


def paint(style: str, text: str, *, on: bool) -> str:
    """Add a style (parameters of Select Graphic Rendition, ECMA-48) to a text, if `on` and not empty."""
    return f"\x1b[{style}m{text}\x1b[0m" if on and style else text


def print_error(error: Exception) -> None:
    """Print an error on stderr, with source lines if it has a place in a scenario."""
    print(error_text(error, colour=use_colour(sys.stderr)), file=sys.stderr)


def diagnostics_of(error: Exception) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of an error; empty if it has no place in the text of a scenario."""
    match error:
        case InvalidScenario(diagnostics=diagnostics):
            return diagnostics
        case UsageError() if found := error.diagnostic:
            from seoro.lang.frozen import replaced  # noqa: PLC0415 - for errors only

            return (replaced(found, message=printable(found.message)),)
        case _:
            return ()


def error_text(error: Exception, colour: bool = False) -> str:
    """Format an error, with source lines if it has a place in a scenario."""
    from seoro.lang.render import render_text  # noqa: PLC0415 - for errors only

    if diagnostics := diagnostics_of(error):
        return "\n\n".join(render_text(found, colour=colour) for found in diagnostics)
    match error:
        case UsageError(help=hint) | BackendUnreachable(help=hint) if hint:
            return printable(f"error: {error}\n  = help: {hint}")
        case _:
            return printable(f"error: {error}")
