"""Sanitising of foreign texts for terminals and logs: no control sequences, no forged lines.

Names, reasons and messages come from clients, robots and scenarios. Use these functions wherever one of them is
printed.
"""

from __future__ import annotations

import logging
import sys
from types import TracebackType
from typing import TypeAlias

_ExceptionInfo: TypeAlias = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None]
)


def printable(text: str) -> str:
    """Replace control characters except line breaks and tabs."""
    return text if text.isprintable() else "".join(c if c.isprintable() or c in "\n\t" else "\ufffd" for c in text)


def one_line(text: str) -> str:
    """Replace control characters, line breaks and tabs, for tables and logs."""
    return text if text.isprintable() else " ".join(printable(text).split())


class PrintableFormatter(logging.Formatter):
    """Log formatter with one line per record, followed by its traceback, if any."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - the name of the base class
        """Format the message in one line."""
        record.message = one_line(record.message)
        return super().formatMessage(record)

    def formatException(self, ei: _ExceptionInfo) -> str:  # noqa: N802 - the name of the base class
        """Format the traceback."""
        return printable(super().formatException(ei))


def log_to_stderr(format: str = "%(levelname)s: %(message)s", level: int = logging.WARNING) -> None:  # noqa: A002
    """Log to stderr, for processes of seoro.

    Args:
        format: Format of a record.
        level: Lowest level that is logged.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(PrintableFormatter(format))
    logging.basicConfig(level=level, handlers=[handler])
