"""Output folder of a run. It removes the results of an earlier run, and keeps all other files.

An index in the folder lists the results of a run. Names are added before files are written, so that a killed run
also has an index.
"""

from __future__ import annotations

from pathlib import Path

from seoro.runtime.execution.outputs import INDEX, RESULT_NAMES, TRACE, add_to_index

_STANDARD = RESULT_NAMES - {"log.txt"}  # the printed output of a run on an executor; a common name for other files


class OutputFolder:
    """Output folder of a run.

    Args:
        folder: The folder; created if missing.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._others: frozenset[str] = frozenset()

    def claim(self) -> None:
        """Remove the results of an earlier run, and start the index of this one.

        Raises:
            OSError: The folder cannot be created or written, or a result cannot be removed.
        """
        self._folder.mkdir(parents=True, exist_ok=True)
        for name in _listed(self._folder):
            _remove(self._folder / name)
        self._others = self._names()
        (self._folder / INDEX).write_text("", encoding="utf-8")
        add_to_index(self._folder, *sorted(_STANDARD - self._others))

    def close(self) -> None:
        """Add new files to the index, such as those of programs that the run started."""
        add_to_index(self._folder, *sorted(self._names() - self._others - _STANDARD - {INDEX}))

    def _names(self) -> frozenset[str]:
        return frozenset(entry.name for entry in self._folder.iterdir())


def _listed(folder: Path) -> list[str]:
    """Names of the results in the folder: those in its index; without one, the standard ones beside a trace."""
    index = folder / INDEX
    if not index.is_file():
        return sorted(_STANDARD) if (folder / TRACE).is_file() else []
    names = index.read_text(encoding="utf-8", errors="replace").splitlines()
    return [name for name in names if name and Path(name).name == name and name != ".."]


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        from shutil import rmtree  # noqa: PLC0415 - seldom needed

        rmtree(path)
    elif path.is_file() or path.is_symlink():
        path.unlink()
