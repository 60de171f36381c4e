"""The files that a command line names: scenario files and folders with such files, traces, stdin; and state."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import IO, Final

from seoro.errors import InvalidUse
from seoro.input_files import Kind, open_input

STDIN = "-"
LARGEST: Final = Kind.SCENARIO.limit or 0  # [bytes] from stdin
STDIN_NAME = "<stdin>"  # in messages
SUFFIX = ".osc"


def state_folder() -> Path:
    """Where what goes on is kept for this user, beyond the end of a process."""
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "seoro"


def node_file(folder: str, name: str, endpoint: str, kind: str) -> Path:
    """Where something of a node is kept, which is known by its name and where it is reached."""
    place = re.sub(r"[^A-Za-z0-9]+", "-", endpoint)
    return state_folder() / folder / f"{name}@{place}.{kind}"


def find_files(arguments: Sequence[str]) -> list[str]:
    """The files, each once, in the order in which they are named; those of a folder by name.

    A file that does not exist is among them: whoever reads it says so.

    Args:
        arguments: Files, and folders, in which hidden folders are left out.

    Raises:
        InvalidUse: A folder has no scenario files, or cannot be read.
    """
    found: dict[str, str] = {}
    for argument in arguments:
        if Path(argument).is_dir():
            inside = list(_files_in(argument))
            if not inside:
                raise InvalidUse(f"there are no {SUFFIX} files in `{argument}`")
        else:
            inside = [argument]
        for file in inside:
            found.setdefault(os.path.realpath(file), file)
    return list(found.values())


def _files_in(folder: str) -> Iterator[str]:
    def fail(error: OSError) -> None:
        raise InvalidUse(f"cannot read the folder `{error.filename}`: {error.strerror}")

    for place, folders, files in os.walk(folder, onerror=fail):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for file in sorted(files):
            if file.endswith(SUFFIX):
                yield str(Path(place, file))


def shown_name(file: str) -> str:
    """What a scenario file is called in messages."""
    return STDIN_NAME if file == STDIN else file


def read_stdin() -> str:
    """The text of a scenario file that comes from stdin.

    Raises:
        InvalidUse: It is too large, or no text.
    """
    data = sys.stdin.buffer.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise InvalidUse(f"what comes from stdin is larger than {LARGEST // 2**20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise InvalidUse(f"what comes from stdin is not UTF-8 (byte {fault.start})") from None


def open_bytes(name: str) -> AbstractContextManager[IO[bytes]]:
    """Open a trace, which is closed after the block, or stdin, which is not.

    Raises:
        OSError: It cannot be read, or is no regular file.
    """
    return nullcontext(sys.stdin.buffer) if name == STDIN else open_input(Path(name), Kind.TRACE)


def count(number: int, what: str = "file") -> str:
    """A number of things in words: `1 file`, `2 files`."""
    return f"{number} {what}{'' if number == 1 else 's'}"
