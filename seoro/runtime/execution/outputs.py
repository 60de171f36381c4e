"""Files that actions write to the output folder of a run, such as pictures."""

from __future__ import annotations

import re
from pathlib import Path

from seoro.errors import ActionFailed
from seoro.lang.frozen import Value

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
# Standard results of runs; simulators write the pictures, measurements and trajectories.
TRACE = "trace.jsonl"
VIDEO = "video.mp4"
RECORDING, LAYOUT = "recording.mcap", "foxglove-layout.json"
TABLES = ("trajectories", "joint_trajectories")  # written as CSV, and as Parquet on request
RESULT_NAMES = frozenset(
    {
        "top_down.png",
        "measurements.json",
        TRACE,
        "test.xml",
        "coverage.json",
        *(f"{name}.{suffix}" for name in TABLES for suffix in ("csv", "parquet")),
        VIDEO,
        RECORDING,
        LAYOUT,
        "report.html",
        "log.txt",
    }
)

INDEX = ".seoro-results"  # in an output folder: names of the results of runs, one per line


def add_to_index(folder: Path, *names: str) -> None:
    """Add names without line breaks to the index of an output folder, if it has one.

    A folder without an index belongs to an embedding program or an executor, which delete it as a whole.
    """
    index = folder / INDEX
    if index.is_file():
        with index.open("a", encoding="utf-8", errors="replace") as file:
            file.writelines(f"{name}\n" for name in names if "\n" not in name)


class OutputFile(Value):
    """A file written by an action, with its description."""

    path: Path
    description: str


class Outputs:
    """Output files of the actions of a run."""

    def __init__(self) -> None:
        self.files: list[OutputFile] = []

    def write(self, folder: Path, name: str, data: bytes, description: str) -> Path:
        """Write a file. Duplicate names of a run get a number.

        Raises:
            ActionFailed: The name is invalid, or the file cannot be written.
        """
        path = self.reserve(folder, name, description)
        try:
            path.write_bytes(data)
        except OSError as error:
            self.files.pop()
            raise ActionFailed(f"cannot write {path}: {error.strerror}") from error
        return path

    def reserve(self, folder: Path, name: str, description: str) -> Path:
        """Reserve a path for a file or a folder that the action writes itself.

        Raises:
            ActionFailed: The name is invalid, or the folder cannot be created.
        """
        if not _NAME.fullmatch(name) or name in RESULT_NAMES:
            raise ActionFailed(
                f"invalid output file name '{name}'; use letters, digits, '.', '_' and '-', a letter or digit "
                f"first, at most 100, and none of {', '.join(sorted(RESULT_NAMES))}"
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
