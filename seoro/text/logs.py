"""Logs of processes, whose records may have foreign texts; apart from `printable`, as `logging` loads slowly."""

from __future__ import annotations

import logging
import sys
from types import TracebackType
from typing import TypeAlias

from seoro.text.printable import one_line, printable

_ExceptionInfo: TypeAlias = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None]
)


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
