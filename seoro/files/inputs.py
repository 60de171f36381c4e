"""Opening of files that users name. A test checks that all readers of such files use this module.

Only regular files are read: a pipe without a writer would block, and a device may be endless. Errors are
`OSError`s, like those of the system, so that readers can report them with context.
"""

from __future__ import annotations

import errno
import os
import stat
from enum import Enum
from io import BufferedReader
from pathlib import Path
from typing import Final

MIB: Final = 1 << 20


class Kind(Enum):
    """Kinds of files, each with a maximum size [bytes]; None if it is read in pieces."""

    SCENARIO = ("scenarios", 4 * MIB)
    SETTINGS = ("YAML files", MIB)
    DEFINITION = ("definitions of interfaces", 4 * MIB)
    MODEL = ("models", 4 * MIB)
    MESH = ("meshes and textures", 64 * MIB)
    WORLD = ("world files", 4 * MIB)
    FLOOR_PLAN = ("floor plans", 64 * MIB)
    SNAPSHOT = ("snapshots", 64 * MIB)
    KEYS = ("files of keys", MIB)
    OUTPUT = ("output files", 256 * MIB)
    METADATA = ("metadata of bags", 16 * MIB)
    BUNDLED = ("files of a bundle", None)
    TRACE = ("traces", None)
    RECORDING = ("recordings", None)
    AUDIT = ("audit logs", None)
    CAMPAIGN = ("files of a campaign", None)

    def __init__(self, title: str, limit: int | None) -> None:
        self.title = title
        self.limit = limit


class UnsuitableFile(OSError):
    """A file of an unsuitable kind or size; the message has the reason, without the path."""

    def __init__(self, reason: str, path: Path) -> None:
        super().__init__(errno.EINVAL, reason, str(path))

    def __str__(self) -> str:
        return str(self.strerror)


_TYPES: Final = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def open_input(path: Path, kind: Kind) -> BufferedReader:
    """Open a file that a user names, for reading.

    Raises:
        OSError: The file cannot be read; `UnsuitableFile` if it is not regular, or too large.
    """
    try:
        _check(path, path.stat(), kind)  # first, since opening a device may have effects
        # Non-blocking, in case the file was replaced by a pipe meanwhile.
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOCTTY | os.O_NONBLOCK)
    except ValueError as error:
        raise UnsuitableFile(f"its path is invalid: {error}", path) from error
    stream = os.fdopen(descriptor, "rb")
    try:
        _check(path, os.fstat(descriptor), kind)
    except BaseException:
        stream.close()
        raise
    return stream


def read_input(path: Path, kind: Kind) -> bytes:
    """Read a file that a user names.

    Raises:
        OSError: As `open_input`.
    """
    with open_input(path, kind) as stream:
        if kind.limit is None:
            return stream.read()
        data = stream.read(kind.limit + 1)  # the file may have grown, and files in /proc report no size
    if len(data) > kind.limit:
        raise _too_large(path, kind)
    return data


def read_input_text(path: Path, kind: Kind) -> str:
    """Read a UTF-8 text that a user names, without its byte order mark.

    Raises:
        OSError: As `open_input`.
        UnicodeDecodeError: The file is not UTF-8.
    """
    text = read_input(path, kind).decode("utf-8-sig")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def failure_reason(error: OSError | UnicodeDecodeError) -> str:
    """Describe why a file cannot be read, without its path."""
    return (
        f"not UTF-8 (byte {error.start})"
        if isinstance(error, UnicodeDecodeError)
        else error.strerror or str(error)
    )


def resolved(path: Path) -> Path:
    """Return the absolute path without links; a cyclic link stays, and cannot be opened."""
    return Path(os.path.realpath(path))


def _check(path: Path, found: os.stat_result, kind: Kind) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        what = _TYPES.get(stat.S_IFMT(found.st_mode), "of an unknown type")
        raise UnsuitableFile(f"it is {what}; expected a regular file", path)
    if kind.limit is not None and found.st_size > kind.limit:
        raise _too_large(path, kind)


def _too_large(path: Path, kind: Kind) -> UnsuitableFile:
    assert kind.limit is not None
    size = f"{kind.limit // MIB} MiB" if kind.limit % MIB == 0 else f"{kind.limit} bytes"
    return UnsuitableFile(f"it is larger than {size}, the limit for {kind.title}", path)
