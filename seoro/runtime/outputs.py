"""Files that actions leave in the output folder of a run, such as pictures, and which they are."""

from __future__ import annotations

import re
from pathlib import Path

from seoro.errors import ActionFailed
from seoro.lang.frozen import Value

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
# Standard results of runs; simulators leave the pictures and the measurements.
RESULT_NAMES = frozenset(
    {
        "top_down.png",
        "measurements.json",
        "trace.jsonl",
        "test.xml",
        "coverage.json",
        "video.mp4",
        "log.txt",
    }
)

INDEX = ".seoro-results"  # in an output folder: the names of what runs have left there, one per line


def add_to_index(folder: Path, *names: str) -> None:
    """Add names to the index of an output folder, if it has one; names without line breaks only.

    A folder without an index belongs to a program that embeds seoro, or to an executor, which remove it whole.
    """
    index = folder / INDEX
    if index.is_file():
        with index.open("a", encoding="utf-8", errors="replace") as file:
            file.writelines(f"{name}\n" for name in names if "\n" not in name)


class OutputFile(Value):
    """A file that an action left, and what it is."""

    path: Path
    description: str


class Outputs:
    """What the actions of a run have left."""

    def __init__(self) -> None:
        self.files: list[OutputFile] = []

    def write(self, folder: Path, name: str, data: bytes, description: str) -> Path:
        """Write a file; when the run has left one of that name already, the new one gets a number.

        Raises:
            ActionFailed: The name is none for a file here, or it cannot be written.
        """
        path = self.reserve(folder, name, description)
        try:
            path.write_bytes(data)
        except OSError as error:
            self.files.pop()
            raise ActionFailed(f"cannot write {path}: {error.strerror}") from error
        return path

    def reserve(self, folder: Path, name: str, description: str) -> Path:
        """A place for a file or a folder that the action writes itself.

        Raises:
            ActionFailed: The name is none for a file here, or there can be no such folder.
        """
        if not _NAME.fullmatch(name) or name in RESULT_NAMES:
            raise ActionFailed(
                f"'{name}' cannot name a file of the output folder: use letters, digits, '.', '_' and '-', a "
                f"letter or digit first, at most 100, and none of {', '.join(sorted(RESULT_NAMES))}"
            )
        path = self._free(folder / name)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            add_to_index(folder, path.name)
        except OSError as error:
            raise ActionFailed(f"cannot write in {folder}: {error.strerror}") from error
        self.files.append(OutputFile(path, description))
        return path

    def _free(self, path: Path) -> Path:
        taken = {file.path for file in self.files}
        number, free = 1, path
        while free in taken:
            number += 1
            free = path.with_name(f"{path.stem}_{number}{path.suffix}")
        return free
