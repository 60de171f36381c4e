"""Report of a run as one HTML file, which needs no network."""

from __future__ import annotations

import base64
import hashlib
import shutil
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import cache
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Final

from seoro.report.blocks import ReadAt
from seoro.report.fallback import content, safe, verdict_word
from seoro.report.folder import results_of
from seoro.report.frames import Frame, command_of
from seoro.report.reading import Reading

REPORT: Final = "report.html"
_LEVEL: Final = 6  # of compression


class Compressed:
    """Bytes that are compressed as they come, so that they are never in memory as a whole."""

    def __init__(self) -> None:
        self._compressor = zlib.compressobj(_LEVEL)
        self._parts: list[bytes] = []

    def write(self, data: bytes) -> None:
        """Append bytes."""
        self._parts.append(self._compressor.compress(data))

    def finish(self) -> bytes:
        """Return all bytes, compressed."""
        return b"".join((*self._parts, self._compressor.flush()))


class NoRecords(ValueError):
    """The file has no records of a run."""


def write_report(trace: IO[bytes], folder: Path | None, output: IO[str], *, space: bool = False) -> Reading:
    """Write the report of a run.

    Args:
        trace: Trace, as JSON Lines. It is read once for the data, and again for the records.
        folder: Folder with other results of the run; None for none.
        output: File for the report.
        space: Whether the page can show the world in three dimensions; this adds 0.6 MB.

    Returns:
        Data of the trace.

    Raises:
        NoRecords: The trace has no valid records.
        OSError: A file cannot be read or written.
    """
    with nullcontext(trace) if trace.seekable() else _copied(trace) as file:
        base, reading = file.tell(), Reading()
        reading.read(file)
        if not reading.count:
            raise NoRecords(reading.problems[0] if reading.problems else "no records")

        def read(start: int, size: int) -> bytes:
            file.seek(base + start)
            return file.read(size)

        for part in page(reading, read, folder, space=space):
            output.write(part)
    return reading


@contextmanager
def _copied(stream: IO[bytes]) -> Iterator[IO[bytes]]:
    """Copy a stream, such as a pipe, which cannot be read again."""
    with TemporaryFile() as file:
        shutil.copyfileobj(stream, file)
        file.seek(0)
        yield file


def page(reading: Reading, read: ReadAt, folder: Path | None, *, space: bool = False) -> Iterator[str]:
    """Yield the parts of the page.

    Args:
        reading: Data of the trace.
        read: Reads the trace.
        folder: Folder with other results of the run; None for none.
        space: Whether the page can show the world in three dimensions.
    """
    columns = Compressed()
    frame = Frame(reading, results_of(folder, reading), columns.write)
    script, style = _static("report.js"), _static("report.css")
    title = f"{verdict_word(reading)}: {(reading.start or {}).get('scenario', 'run')}"
    scripts = (script, _static("world3d.js")) if space else (script,)
    yield from _head(title, scripts, style)
    yield '<body><div id="app"><main class="fallback">'
    yield from content(reading, command_of(reading))
    yield "</main></div>"
    yield _script("seoro-meta", zlib.compress(frame.text, _LEVEL))
    yield _script("seoro-columns", columns.finish())
    yield from (f"<script>{each}</script>" for each in scripts)
    for number, block in enumerate(reading.blocks):  # the page is shown before it has them
        yield _script(f"seoro-block-{number}", block.compressed(read))
    yield "</body></html>\n"


def _head(title: str, scripts: Sequence[str], style: str) -> Iterator[str]:
    allowed = " ".join(f"'{_hash(script)}'" for script in scripts)
    policy = (
        f"default-src 'none'; script-src {allowed}; style-src '{_hash(style)}'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    space = " data-space" if len(scripts) > 1 else ""
    yield f'<!doctype html><html lang="en"{space}><head><meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    yield '<meta name="viewport" content="width=device-width,initial-scale=1">'
    yield '<meta name="color-scheme" content="light dark"><meta name="referrer" content="no-referrer">'
    yield f"<title>{safe(title)}</title><style>{style}</style></head>"


def style_policy(style: str) -> str:
    """Return the Content-Security-Policy of a page with one style sheet, and nothing else."""
    return f"default-src 'none'; style-src '{_hash(style)}'; base-uri 'none'; form-action 'none'"


def _script(name: str, compressed: bytes) -> str:
    text = base64.b64encode(compressed).decode("ascii")
    return f'<script type="application/octet-stream" id="{name}">{text}</script>\n'


@cache
def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


@cache
def _static(name: str) -> str:
    return (files("seoro.report") / "static" / name).read_text(encoding="utf-8")
