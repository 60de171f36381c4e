"""Comparison of two runs as one HTML file, without JavaScript and network."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from seoro.report.comparison.picture import picture
from seoro.report.comparison.runs import ComparedRun
from seoro.report.comparison.style import STYLE
from seoro.report.fallback import safe
from seoro.report.page import style_policy
from seoro.traces.comparison import Comparison
from seoro.traces.difference import Difference, Side
from seoro.traces.difference_text import side_lines

_LONGEST: Final = 2_000  # [characters] of a value
_MOST_ROWS: Final = 500  # of a table
_NUMBER: Final = (int, float)
Row = tuple[str, object, object]


def comparison_page(first: ComparedRun, second: ComparedRun, comparison: Comparison) -> Iterator[str]:
    """Yield the parts of the page.

    Args:
        first: Run A.
        second: Run B.
        comparison: Their differences.
    """
    title = f"{first.name} and {second.name}"
    yield '<!doctype html><html lang="en"><head><meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{style_policy(STYLE)}">'
    yield '<meta name="viewport" content="width=device-width,initial-scale=1">'
    yield '<meta name="color-scheme" content="light dark"><meta name="referrer" content="no-referrer">'
    yield f"<title>{_text(title)}: comparison</title><style>{STYLE}</style></head><body><main>"
    yield f"<h1>{_text(title)}</h1>"
    yield '<div class="pair">'
    yield from (_verdict(letter, run) for letter, run in zip("AB", (first, second), strict=True))
    yield "</div>"
    yield from _difference(comparison.difference)
    drawn = list(picture(first, second, _times(comparison.difference, first, second)))
    if drawn:
        yield '<h2>Paths</h2><div class="card world">'
        yield from drawn
        yield "</div>"
    yield from _table("Settings that differ", comparison.settings)
    yield from _table("Measurements that differ", list(_measurements(first, second)), is_numeric=True)
    yield "</main></body></html>\n"


def _verdict(letter: str, run: ComparedRun) -> str:
    reason = "" if run.end is None else run.end["reason"]
    source = "" if run.end is None else run.end.get("source") or ""
    scenario = run.start.get("scenario", "")
    parts = [
        f'<div class="card verdict {run.status.split(" ")[0]}"><h2>{_letter(letter)}{_text(run.name)}</h2>',
        f'<p>{_text(scenario)} <span class="status">{run.status}</span> after {run.time:.3f} s</p>',
        f"<p>{_text(reason)}</p>" if reason else "",
        f'<p class="muted">{_text(source)}</p>' if source else "",
        "</div>",
    ]
    return "".join(parts)


def _letter(letter: str) -> str:
    return f'<span class="letter {letter.lower()}">{letter}</span>'


def _difference(difference: Difference | None) -> Iterator[str]:
    yield "<h2>First difference</h2>"
    if difference is None:
        yield '<p class="card equal">None: everything happened at the same times.</p>'
        return
    yield (
        "<p>The runs differ from the start.</p>"
        if difference.common is None
        else (f"<p>Everything until <b>{difference.common:.3f} s</b> is equal. Then:</p>")
    )
    yield '<div class="pair">'
    for letter, side in (("A", difference.first), ("B", difference.second)):
        when = "" if side.time is None else f", at {side.time:.3f} s"
        lines = "".join(f"<li>{_text(line)}</li>" for line in side_lines(side))
        yield f'<div class="card"><h3>{_letter(letter)}only in {letter}{when}</h3><ul>{lines}</ul></div>'
    yield "</div>"


def _times(difference: Difference | None, first: ComparedRun, second: ComparedRun) -> tuple[float, float] | None:
    if difference is None:
        return None
    return _time(difference.first, first), _time(difference.second, second)


def _time(side: Side, run: ComparedRun) -> float:
    return run.time if side.time is None else side.time


def _measurements(first: ComparedRun, second: ComparedRun) -> Iterator[Row]:
    ours, theirs = (dict(_flat(run.measurements)) for run in (first, second))
    for name in dict.fromkeys((*ours, *theirs)):
        if ours.get(name) != theirs.get(name):
            yield name, ours.get(name, ""), theirs.get(name, "")


def _flat(found: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    for name, value in found.items():
        if isinstance(value, dict) and prefix.count(".") < 4:
            yield from _flat(value, f"{prefix}{name}.")
        elif not isinstance(value, list):
            yield f"{prefix}{name}", value


def _table(title: str, rows: Sequence[Row], *, is_numeric: bool = False) -> Iterator[str]:
    if not rows:
        return
    more = '<th scope="col" class="number">B \N{MINUS SIGN} A</th>' if is_numeric else ""
    yield f'<h2>{title}</h2><div class="scroll" tabindex="0" role="region" aria-label="{title}"><table><thead><tr>'
    yield f'<th scope="col">name</th>{_head("A", is_numeric)}{_head("B", is_numeric)}{more}</tr></thead><tbody>'
    for name, ours, theirs in rows[:_MOST_ROWS]:
        cells = "".join(map(_cell, (ours, theirs)))
        step = _cell(_step(ours, theirs)) if is_numeric else ""
        yield f'<tr><th scope="row">{_text(name)}</th>{cells}{step}</tr>'
    yield "</tbody></table></div>"
    if (omitted := len(rows) - _MOST_ROWS) > 0:
        yield f'<p class="muted">{omitted:,} further ones</p>'


def _head(letter: str, is_numeric: bool) -> str:
    kind = ' class="number"' if is_numeric else ""
    return f'<th scope="col"{kind}>{letter}</th>'


def _step(ours: object, theirs: object) -> object:
    if not (_is_number(ours) and _is_number(theirs)):
        return ""
    found = theirs - ours  # type: ignore[operator]  # both are numbers
    return f"{found:+.6g}" if math.isfinite(found) else ""


def _is_number(value: object) -> bool:
    return isinstance(value, _NUMBER) and not isinstance(value, bool)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f'<td class="number">{value:.6g}</td>'
    is_number = _is_number(value) or (isinstance(value, str) and value[:1] in "+-" and value[1:2].isdigit())
    kind = ' class="number"' if is_number else ""
    return f"<td{kind}>{_text(value)}</td>"


def _text(value: object) -> str:
    text = "" if value is None else str(value)
    return safe(text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "\N{HORIZONTAL ELLIPSIS}")
