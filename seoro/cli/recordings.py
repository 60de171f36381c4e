"""Recordings in MCAP, made from traces: `recording.mcap` of a run, and `seoro trace --mcap`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from seoro.cli.files import write_errors
from seoro.cli.packages import require
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.runtime.execution.outputs import LAYOUT, RECORDING
from seoro.traces.foxglove import PACKAGE, is_foxglove_installed
from seoro.traces.reader import read_trace, valid_records

MAX_TRACE: Final = 64 << 20  # [bytes] of a trace that is converted at the end of its run
_BEGIN: Final = 65_536  # [bytes] of a trace in which the scene of its world begins
_SCENE: Final = b'"kind": "scene"'


def recorded(trace: Path) -> list[tuple[Path, str]]:
    """Write the recording of a run in a simulator beside its trace; return the files with descriptions.

    Nothing is written without the extra, without a scene, and for very long traces.

    Raises:
        UsageError: A file cannot be written.
    """
    if not (is_foxglove_installed() and trace.is_file() and trace.stat().st_size <= MAX_TRACE):
        return []
    with open_input(trace, Kind.TRACE) as file:
        if _SCENE not in file.read(_BEGIN):
            return []
        file.seek(0)
        path = trace.with_name(RECORDING)
        write(valid_records(read_trace(file), []), path)
    return [(path, "recording for Foxglove"), (trace.with_name(LAYOUT), "layout for Foxglove")]


def write(records: Iterable[dict[str, Any]], path: Path) -> None:
    """Write a recording and its layout.

    Raises:
        UsageError: The extra is missing, a file cannot be written, or a record is invalid.
    """
    require("a recording", "recording", PACKAGE)
    from seoro.traces.foxglove.recording import write_recording  # noqa: PLC0415 - slow to load, and optional

    try:
        with write_errors(path):
            write_recording(records, path)
    except (ValueError, RuntimeError) as error:  # errors of the package's writer are `RuntimeError`
        raise UsageError(f"cannot write {path}: {error}") from error
