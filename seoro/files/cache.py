"""Files in the user's cache folder, with checksums. Each is read as a whole or not at all, and may be missing.

Files and folders that other users own or can change are ignored. A read-only folder is allowed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
from pathlib import Path

MAX_SIZE = 16 * 2**20  # bytes of a file


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of files; None if the user has no home."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError:
        return None
    return Path(home) / "seoro" / name


def digest_of(text: str) -> str:
    """Return the SHA-256 of a text.

    Raises:
        UnicodeEncodeError: The text cannot be encoded.
    """
    return hashlib.sha256(text.encode()).hexdigest()


def stamps_of(files: list[Path]) -> str:
    """Return the sizes and times of files as a text that changes with any file.

    Raises:
        OSError: A file is missing.
    """
    found = (path.stat() for path in files)
    return "\n".join(f"{each.st_size} {each.st_mtime_ns}" for each in found)


def read_cached(path: Path) -> bytes | None:
    """Read the content of a file; None if it is missing, too large or damaged, or not the user's alone."""
    try:
        with path.open("rb") as stream:
            if not (_is_private(os.fstat(stream.fileno())) and _is_private(path.parent.stat())):
                return None
            data = stream.read(MAX_SIZE + 1)
    except (OSError, ValueError):
        return None
    checksum, _, content = data.partition(b"\n")
    return content if len(data) <= MAX_SIZE and checksum == _checksum(content) else None


def _is_private(found: os.stat_result) -> bool:
    """Return whether a file or a folder belongs to the user, and only the user can change it."""
    return found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def write_cached(path: Path, content: bytes) -> None:
    """Write a file for its user only; readers see all of it or nothing.

    Raises:
        OSError: It cannot be written.
    """
    data = _checksum(content) + b"\n" + content
    if len(data) > MAX_SIZE:
        return
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    new = path.with_name(f"{os.urandom(8).hex()}.new")
    handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        new.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            new.unlink()
        raise


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
