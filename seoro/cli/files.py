"""Files named on the command line (scenarios, folders, traces, stdin), and state files of the user."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.errors import UsageError
from seoro.files.inputs import Kind

if TYPE_CHECKING:
    from seoro.lang.loader import Reader

STDIN = "-"
LARGEST: Final = Kind.SCENARIO.limit or 0  # [bytes] from stdin
STDIN_NAME = "<stdin>"  # in messages
SUFFIX = ".osc"


def state_folder() -> Path:
    """Return the folder for persistent state of this user."""
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "seoro"


def node_file(folder: str, name: str, endpoint: str, kind: str) -> Path:
    """Return the path of a state file of a node, identified by its name and endpoint."""
    place = re.sub(r"[^A-Za-z0-9]+", "-", endpoint)
    return state_folder() / folder / f"{name}@{place}.{kind}"


def find_files(arguments: Sequence[str]) -> list[str]:
    """List files once each, in the order of the arguments; files of a folder are sorted by name.

    Missing files are kept; reading them reports the error.

    Args:
        arguments: Files and folders. Hidden subfolders are skipped.

    Raises:
        UsageError: A folder has no scenario files, or cannot be read.
    """
    found: dict[str, str] = {}
    for argument in arguments:
        if Path(argument).is_dir():
            inside = list(_files_in(argument))
            if not inside:
                raise UsageError(f"no {SUFFIX} files in the folder `{argument}`")
        else:
            inside = [argument]
        for file in inside:
            found.setdefault(os.path.realpath(file), file)
    return list(found.values())


def _files_in(folder: str) -> Iterator[str]:
    def fail(error: OSError) -> None:
        raise UsageError(f"cannot read the folder `{error.filename}`: {error.strerror}")

    for place, folders, files in os.walk(folder, onerror=fail):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for file in sorted(files):
            if file.endswith(SUFFIX):
                yield str(Path(place, file))


def shown_name(file: str) -> str:
    """Return the name of a scenario file in messages."""
    return STDIN_NAME if file == STDIN else file


def read_stdin() -> str:
    """Read a scenario from stdin.

    Raises:
        UsageError: The input is too large, or not UTF-8.
    """
    data = sys.stdin.buffer.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise UsageError(f"stdin is too large: more than {LARGEST // 2**20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise UsageError(f"stdin is not UTF-8 (byte {fault.start})") from None


def named_source(file: str) -> tuple[Path, Reader]:
    """Return the path of a scenario file, and the reader for it and its imports.

    Imports of stdin are relative to the working directory.

    Raises:
        UsageError: The file is stdin, and it is invalid.
    """
    from seoro.lang.loader import read_file  # noqa: PLC0415 - not needed for cached plans

    if file != STDIN:
        return Path(file), read_file
    path, text = Path(STDIN_NAME), read_stdin()
    return path, lambda other: text if other == path else read_file(other)


@contextmanager
def write_errors(path: Path) -> Iterator[None]:
    """Convert errors of writing a file into `UsageError`s."""
    try:
        yield
    except FileExistsError as error:
        raise UsageError(f"cannot write {path}: {error.filename} is not a folder") from error
    except BrokenPipeError:
        raise
    except OSError as error:
        inside = error.filename is not None and Path(error.filename).is_relative_to(path)
        raise UsageError(f"cannot write {error.filename if inside else path}: {error.strerror}") from error


def count(number: int, what: str = "file") -> str:
    """Format a number of things: `1 file`, `2 files`."""
    return f"{number} {what}{'' if number == 1 else 's'}"
