"""The folder for the results of one run: the results of the run before are removed, files of others are kept.

An index in the folder lists what a run has left there. A run that is killed leaves an index, too, since names are
added before files are written.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from seoro.errors import InvalidUse
from seoro.runtime.outputs import INDEX, RESULT_NAMES, add_to_index

_STANDARD = RESULT_NAMES - {"log.txt"}  # the printed output of a run on an executor; a common name for other files


class OutputFolder:
    """Output folder of a run.

    Args:
        folder: The folder; it is made if it does not exist.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._others: frozenset[str] = frozenset()

    def claim(self) -> None:
        """Remove the results of an earlier run, and start an index of those of this one.

        Raises:
            InvalidUse: The folder cannot be made or written, or a result cannot be removed.
        """
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            for name in _listed(self._folder):
                _remove(self._folder / name)
            self._others = self._names()
            (self._folder / INDEX).write_text("", encoding="utf-8")
            add_to_index(self._folder, *sorted(_STANDARD - self._others))
        except OSError as error:
            raise InvalidUse(f"cannot write {error.filename or self._folder}: {error.strerror}") from error

    def close(self) -> None:
        """Add what has appeared in the folder during the run, such as files of programs that it started."""
        add_to_index(self._folder, *sorted(self._names() - self._others - _STANDARD - {INDEX}))

    def _names(self) -> frozenset[str]:
        return frozenset(entry.name for entry in self._folder.iterdir())


def _listed(folder: Path) -> list[str]:
    """Names of the results in the folder: those in its index; without one, the standard ones beside a trace."""
    index = folder / INDEX
    if not index.is_file():
        return sorted(_STANDARD) if (folder / "trace.jsonl").is_file() else []
    names = index.read_text(encoding="utf-8", errors="replace").splitlines()
    return [name for name in names if name and Path(name).name == name and name != ".."]


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    elif path.is_file() or path.is_symlink():
        path.unlink()
