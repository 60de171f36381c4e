"""Traces that are named on the command line."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import IO

from seoro.cli.files import STDIN
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.runtime.execution.outputs import TRACE
from seoro.traces.reader import InvalidRecord, Record, read_trace, valid_records


def open_trace(name: str) -> AbstractContextManager[IO[bytes]]:
    """Open a trace, or stdin for `-`. The block closes only files.

    Raises:
        UsageError: The file cannot be read, or is not a regular file.
    """
    if name == STDIN:
        return nullcontext(sys.stdin.buffer)
    try:
        return open_input(Path(name), Kind.TRACE)
    except OSError as error:
        raise UsageError(f"cannot read the trace {name}: {error.strerror}") from error


def trace_of(name: str) -> tuple[str, Path | None]:
    """Return the trace of a run, and the folder with its other results.

    Raises:
        UsageError: A folder has no trace.
    """
    path = Path(name)
    if name == STDIN:
        return name, None
    if not path.is_dir():
        return name, path.parent
    if not (path / TRACE).is_file():
        raise UsageError(f"no {TRACE} in the folder {name}", help="`seoro exec -o DIR` writes one")
    return str(path / TRACE), path


def invalid_trace(name: str, problems: Sequence[InvalidRecord]) -> UsageError:
    """Make the error for a trace with invalid lines, or without records."""
    reason = str(problems[0]) if problems else "file is empty"
    return UsageError(f"invalid trace {name}: {reason}", help="`seoro exec --trace FILE` writes a trace")


def read_records(name: str) -> list[Record]:
    """Read the records of a trace; `-` is stdin.

    Raises:
        UsageError: The trace cannot be read, is invalid, or is empty.
    """
    problems: list[InvalidRecord] = []
    with open_trace(name) as file:
        records = list(valid_records(read_trace(file), problems))
    if problems or not records:
        raise invalid_trace(name, problems)
    return records
