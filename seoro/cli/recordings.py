"""Recordings in MCAP, made from traces: `recording.mcap` of a run, and `seoro trace --mcap`."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from seoro.cli.files import write_errors
from seoro.cli.packages import ROS2, require
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.runtime.execution.outputs import LAYOUT, RECORDING, VIDEO
from seoro.traces.films import film_stills
from seoro.traces.foxglove import PACKAGE, is_foxglove_installed
from seoro.traces.reader import read_trace, valid_records

MAX_TRACE: Final = 64 << 20  # [bytes] of a trace that is converted at the end of its run
MAX_FILM: Final = 256 << 20  # [bytes] of a film that is included
_DECODER: Final = "av"
_PLACED: Final = (b'"kind": "scene"', b'"kind": "entity"')  # in traces with poses


def recorded(trace: Path) -> list[tuple[Path, str]]:
    """Write the recording of a run with poses beside its trace; return the files with descriptions.

    Nothing is written without the extra, without poses, and for very long traces.

    Raises:
        UsageError: A file cannot be written.
    """
    if not (is_foxglove_installed() and trace.is_file() and trace.stat().st_size <= MAX_TRACE):
        return []
    with open_input(trace, Kind.TRACE) as file:
        if not any(mark in line for line in file for mark in _PLACED):
            return []
        file.seek(0)
        path, film = trace.with_name(RECORDING), trace.with_name(VIDEO)
        is_shown = film.is_file() and film.stat().st_size <= MAX_FILM and find_spec(_DECODER) is not None
        write(valid_records(read_trace(file), []), path, film if is_shown else None)
    return [(path, "recording for Foxglove"), (trace.with_name(LAYOUT), "layout for Foxglove")]


def write(records: Iterable[dict[str, Any]], path: Path, film: Path | None = None) -> None:
    """Write a recording and its layout.

    Args:
        records: Records of the run.
        path: The recording.
        film: Film of the whole run; None for none.

    Raises:
        UsageError: An extra is missing, a file cannot be read or written, or a record or the film is invalid.
    """
    require("a recording", "recording", PACKAGE)
    if film is not None:
        require("a film in a recording", "video", _DECODER)
    from seoro.traces.foxglove.recording import write_recording  # noqa: PLC0415 - slow to load, and optional

    try:
        with write_errors(path):
            write_recording(records, path, film)
    except (ValueError, RuntimeError) as error:  # errors of the package's writer are `RuntimeError`
        raise UsageError(f"cannot write {path}: {error}") from error


def write_bag(records: Iterable[dict[str, Any]], folder: Path, film: Path | None = None) -> None:
    """Write a bag of ROS 2.

    Args:
        records: Records of the run.
        folder: Folder of the bag, which must not exist.
        film: Film of the whole run; None for none.

    Raises:
        UsageError: A package is missing, the folder exists or cannot be written, or the film or a record is
            invalid.
    """
    require("a bag", "ros2", *ROS2)
    if film is not None:
        require("a film in a bag", "video", _DECODER)
    from seoro.bridges.ros2.recording.trace_bag import write_trace_bag  # noqa: PLC0415 - slow to load, and optional

    try:
        with write_errors(folder):
            write_trace_bag(records, folder, () if film is None else film_stills(film))
    except ValueError as error:
        raise UsageError(f"cannot write {folder}: {error}") from error
