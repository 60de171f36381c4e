"""Folders of runs below a folder: results of `seoro exec -o`, kept runs of campaigns, runs of executors."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from seoro.campaign.store.folder import CAMPAIGN, KEPT
from seoro.files.inputs import Kind, open_input, read_input
from seoro.runtime.execution.outputs import INDEX, TRACE
from seoro.traces.edges import read_end

_DIGITS: Final = 6  # of the folder of a kept run of a campaign, at least


@dataclass(frozen=True)
class RunFolder:
    """Folder with the results of a run.

    Attributes:
        path: The folder.
        ended: Time of the last change of its trace [s since the epoch].
        size: Size of its results [bytes].
        status: Status of the run; empty if it has not ended.
        names: Names of the results; None if the whole folder belongs to the run.
    """

    path: Path
    ended: float
    size: int
    status: str
    names: tuple[str, ...] | None = None

    def remove(self) -> None:
        """Delete the results, and the folder if nothing else is in it.

        Raises:
            OSError: A file cannot be deleted.
        """
        if self.names is None:
            shutil.rmtree(self.path)
            return
        for name in self.names:
            _remove(self.path / name)
        _remove(self.path / INDEX)
        if not any(self.path.iterdir()):
            self.path.rmdir()


def find_runs(root: Path) -> Iterator[RunFolder]:
    """Yield the folders of runs below a folder; links are not followed."""
    for place, folders, files in os.walk(root):
        path = Path(place)
        folders[:] = sorted(name for name in folders if not (path / name).is_symlink())
        if CAMPAIGN in files and KEPT in folders:
            folders.remove(KEPT)
            yield from _kept_runs(path / KEPT)
        elif INDEX in files and TRACE in files:
            names = _results(path)
            folders[:] = [name for name in folders if name not in names]
            yield _run_folder(path, names)


def _kept_runs(folder: Path) -> Iterator[RunFolder]:
    for path in sorted(folder.iterdir()):
        is_numbered = path.name.isdecimal() and len(path.name) >= _DIGITS
        if is_numbered and not path.is_symlink() and (path / TRACE).is_file():
            yield _run_folder(path, None)


def _run_folder(path: Path, names: tuple[str, ...] | None) -> RunFolder:
    parts = [path] if names is None else [path / name for name in names]
    trace = path / TRACE
    return RunFolder(path, trace.stat().st_mtime, sum(map(size_of, parts)), _status(trace), names)


def _results(folder: Path) -> tuple[str, ...]:
    """Return the names of the results of a run: those of its index that are in the folder, without paths."""
    listed = read_input(folder / INDEX, Kind.OUTPUT).decode(errors="replace").splitlines()
    names = {name for name in listed if name and Path(name).name == name and name != ".."}
    return tuple(sorted(name for name in names if os.path.lexists(folder / name)))


def _status(trace: Path) -> str:
    """Return the status in the last record of a trace; empty without an end."""
    with open_input(trace, Kind.TRACE) as file:
        end = read_end(file)
    return "" if end is None else str(end.get("status", ""))


def size_of(path: Path) -> int:
    """Return the size of a file, or of all files in a folder [bytes]; links are not followed."""
    if path.is_symlink() or not path.is_dir():
        return path.lstat().st_size if path.is_symlink() or path.exists() else 0
    places = (Path(place, name) for place, _, files in os.walk(path) for name in files)
    return sum(each.lstat().st_size for each in places)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
