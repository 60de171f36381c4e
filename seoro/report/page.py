"""Report of a run as one HTML file, which needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import zlib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import IO, Any, Final

from seoro.report.blocks import KINDS
from seoro.report.columns import STEP, Packed
from seoro.report.fallback import content, safe, verdict_word
from seoro.report.folder import add_trajectories, read_json
from seoro.report.reading import Reading
from seoro.report.repeat import repeat_command
from seoro.report.rows import STATUSES

REPORT: Final = "report.html"
_LEVEL: Final = 6  # of compression


class NoRecords(ValueError):
    """The file has no records of a run."""


def write_report(trace: IO[bytes], folder: Path | None, output: IO[str]) -> Reading:
    """Write the report of a run.

    Args:
        trace: Trace, as JSON Lines.
        folder: Folder with other results of the run; None for none.
        output: File for the report.

    Returns:
        Data of the trace.

    Raises:
        NoRecords: The trace has no valid records.
        OSError: A file cannot be read or written.
    """
    reading = Reading()
    reading.read(trace)
    if not reading.count:
        raise NoRecords(reading.problems[0] if reading.problems else "no records")
    for part in page(reading, folder):
        output.write(part)
    return reading


def page(reading: Reading, folder: Path | None) -> Iterator[str]:
    """Yield the parts of the page."""
    measurements = coverage = {}
    if folder is not None:
        measurements = read_json(folder / "measurements.json")
        coverage = read_json(folder / "coverage.json")
        add_trajectories(folder / "trajectories.csv", reading)
    if reading.scene is None and measurements:
        reading.scene = {"simulator": measurements.get("engine"), "world": measurements.get("world")}
    scene = reading.scene or {}
    command = "" if reading.start is None else repeat_command(reading.start, scene)
    packed = Packed()
    reading.pack(packed)
    meta = _meta(reading, packed) | {"command": command, "measurements": measurements, "coverage": coverage}
    script, style = _static("report.js"), _static("report.css")
    title = f"{verdict_word(reading)}: {(reading.start or {}).get('scenario', 'run')}"
    yield from _head(title, script, style)
    yield '<body><div id="app"><main class="fallback">'
    yield from content(reading, command)
    yield "</main></div>"
    yield _data("seoro-meta", _json(meta))
    yield _data("seoro-columns", bytes(packed.data))
    for number, block in enumerate(reading.blocks.blocks):
        yield _script(f"seoro-block-{number}", block)
    yield f"<script>{script}</script></body></html>\n"


def _meta(reading: Reading, packed: Packed) -> dict[str, Any]:
    """Return all data of the page but columns and records."""
    entities = list(reading.tracks.pack(packed))
    series = list(reading.series.pack(packed))
    return {
        "start": reading.start,
        "end": reading.end,
        "scene": reading.scene,
        "sources": reading.sources,
        "tree": reading.tree,
        "time": reading.time,
        "count": reading.count,
        "kinds": KINDS,
        "counts": reading.kinds,
        "statuses": STATUSES,
        "step": STEP,
        "rows": [row.plain() for row in reading.behaviors.rows],
        "strings": reading.strings.texts,
        "entities": entities,
        "beams": reading.tracks.beams,
        "series": series,
        "blocks": reading.blocks.directory,
        "layout": packed.layout,
        "margins": reading.margins,
        "samples": reading.samples,
        "notes": list(_notes(reading)),
    }


def _json(value: object) -> bytes:
    try:
        text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    except ValueError:  # NaN and infinity, which traces of other writers may have
        text = json.dumps(_finite(value), ensure_ascii=False)
    return text.encode("utf-8", "replace")


def _finite(value: object) -> object:
    match value:
        case float() if not math.isfinite(value):
            return str(value)
        case dict():
            return {name: _finite(part) for name, part in value.items()}
        case list() | tuple():
            return [_finite(part) for part in value]
        case _:
            return value


def _notes(reading: Reading) -> Iterator[str]:
    """Yield sentences about what the report cannot show."""
    if reading.end is None:
        cut = " Its last line is incomplete." if reading.is_cut else ""
        yield f"The trace has no end: the run was killed, or is still active.{cut}"
    if reading.start is None:
        yield "The trace has no beginning: records are missing."
    if reading.further_runs:
        yield "The file has more runs. This report shows the first one."
    for problem in reading.problems:
        yield f"Invalid {problem}"
    omitted = (
        (reading.behaviors.omitted, "behaviors share the row of their parent"),
        (reading.series.omitted, "values of further series"),
        (reading.tracks.omitted, "samples of poses, paths and scans"),
    )
    for number, what in omitted:
        if number:
            yield f"Left out: {number:,} {what}."


def _head(title: str, script: str, style: str) -> Iterator[str]:
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    yield '<!doctype html><html lang="en"><head><meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    yield '<meta name="viewport" content="width=device-width,initial-scale=1">'
    yield '<meta name="color-scheme" content="light dark"><meta name="referrer" content="no-referrer">'
    yield f"<title>{safe(title)}</title><style>{style}</style></head>"


def _data(name: str, data: bytes) -> str:
    return _script(name, zlib.compress(data, _LEVEL))


def _script(name: str, compressed: bytes) -> str:
    text = base64.b64encode(compressed).decode("ascii")
    return f'<script type="application/octet-stream" id="{name}">{text}</script>\n'


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


def _static(name: str) -> str:
    return (files("seoro.report") / "static" / name).read_text(encoding="utf-8")
