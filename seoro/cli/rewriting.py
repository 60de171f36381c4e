"""Changes of scenario files: atomic replacement, and diffs."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Final

from seoro.cli.terminal import paint, use_colour
from seoro.files.inputs import resolved
from seoro.lang.source import SourceFile

_STYLES: Final = {"-": "31", "+": "32", "@": "36"}  # of the lines of a diff


def replace_file(path: Path, text: str) -> None:
    """Replace a file atomically, keeping its permissions and links to it."""
    path = resolved(path)
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        with new.open("xb") as stream:
            stream.write(text.encode())
            stream.flush()
            os.fsync(stream.fileno())
        new.chmod(path.stat().st_mode & 0o7777)
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def print_diff(file: SourceFile, text: str) -> None:
    """Print a unified diff, coloured on terminals."""
    from difflib import unified_diff  # noqa: PLC0415 - slow to load, and seldom needed

    on = use_colour(sys.stdout)
    before = [file.line(number) for number in range(1, file.line_count + 1)]
    for line in unified_diff(before, text.split("\n"), file.name, file.name, lineterm=""):
        print(paint(_STYLES.get(line[:1], ""), line, on=on))
