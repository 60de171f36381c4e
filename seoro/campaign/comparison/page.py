"""Comparison of two campaigns as one HTML file in the style of the report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Final

from seoro.campaign.comparison.comparing import Comparison, Outcome, replay_command
from seoro.campaign.comparison.measurements import MeasurementChange
from seoro.campaign.comparison.pairs import Pair
from seoro.campaign.comparison.text import number_text, p_text, verdict_lines
from seoro.campaign.report.charts import change_chart, floor_of, rate_chart
from seoro.campaign.report.grouping import Bucket, influence
from seoro.campaign.report.page import without_controls
from seoro.campaign.report.style import STYLE
from seoro.campaign.statistics.rates import Bounds

_MOST_RUNS: Final = 200  # of each list
_MOST_CHARTS: Final = 6
_MOST_CHANGES: Final = 12  # of a chart
_BARS: Final = 10


def write_comparison(comparison: Comparison, path: Path) -> None:
    """Write a comparison as HTML.

    Args:
        comparison: The comparison.
        path: The file.

    Raises:
        OSError: It cannot be written.
    """
    path.write_text(without_controls("".join(_page(comparison))), encoding="utf-8")


def summary_html(comparison: Comparison) -> str:
    """Return a comparison for notebooks: its outcome, and measurements that changed."""
    lines = "".join(f"<p>{escape(line)}</p>" for line in verdict_lines(comparison))
    changed = [each for each in comparison.measurements if each.is_significant]
    return f"<p><b>{escape(comparison.outcome.value)}</b></p>{lines}{_table(changed) if changed else ''}"


def _page(comparison: Comparison) -> Iterator[str]:
    title = escape(f"{comparison.before} and {comparison.after}")
    yield '<!doctype html><html lang="en"><head><meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width,initial-scale=1">'
    yield f"<title>{title}: comparison</title><style>{STYLE}</style></head><body>"
    yield f"<h1>{title}</h1>"
    yield f'<div class="verdict{"" if comparison.outcome is Outcome.NOT_WORSE else " bad"}">'
    yield f"<b>{escape(comparison.outcome.value.capitalize())}</b>"
    yield from (f"<p>{escape(line)}</p>" for line in verdict_lines(comparison))
    yield "</div>"
    yield from _rates(comparison)
    yield from _runs("Newly failing", comparison, comparison.failing)
    yield from _runs("Newly passing", comparison, comparison.passing)
    yield from _runs("Without a verdict now", comparison, comparison.lost)
    yield from _measurements(comparison)
    yield from _differences(comparison)
    yield "</body></html>\n"


def _rates(comparison: Comparison) -> Iterator[str]:
    buckets = [
        Bucket(label, passed, runs - passed)
        for label, (passed, runs) in zip(("before", "after"), comparison.counts, strict=True)
        if runs
    ]
    if not buckets:
        return
    yield '<h2>Pass rates</h2><div class="cards">'
    yield _card("Before and after", rate_chart(buckets, floor_of(buckets)))
    if comparison.failing:
        yield from _still_passing(comparison)
    yield "</div>"
    yield '<p class="note">The mark is the rate, the bar its 95 % interval, the number passed/runs. '
    yield "Of parameters, the charts show runs that passed before, and how many of these still pass.</p>"


def _still_passing(comparison: Comparison) -> Iterator[str]:
    columns = comparison.joined.parameters
    groupings = {path: column.grouping(_BARS).buckets for path, column in columns.items()}
    order = sorted(groupings, key=lambda path: -influence(groupings[path]))[:_MOST_CHARTS]
    floor = floor_of(bucket for path in order for bucket in groupings[path])
    yield from (_card(f"Still passing by {path}", rate_chart(groupings[path], floor)) for path in order)


def _runs(title: str, comparison: Comparison, pairs: Sequence[Pair]) -> Iterator[str]:
    if not pairs:
        return
    shown = list(pairs[:_MOST_RUNS])
    paths = list(dict.fromkeys(path for pair in shown for path in pair.values))
    yield f"<h2>{title}: {len(pairs):,}</h2>"
    yield _scroll(
        ["run before", "run after", "seed", *paths, "reason now", "commands"],
        (_line(comparison, pair, paths) for pair in shown),
    )
    if len(pairs) > len(shown):
        yield f'<p class="note">The first {len(shown):,} of {len(pairs):,}</p>'


def _line(comparison: Comparison, pair: Pair, paths: Sequence[str]) -> str:
    commands = (replay_command(comparison.before, pair.before.run), comparison.command(pair))
    shown = "<br>".join(f"<code>{escape(command)}</code>" for command in commands)
    values = [pair.before.run, pair.after.run, pair.seed, *(pair.values.get(path, "") for path in paths)]
    cells = "".join(f'<td class="number">{_short(value)}</td>' for value in values)
    return f'{cells}<td class="reason">{_short(pair.reason)}</td><td>{shown}</td>'


def _measurements(comparison: Comparison) -> Iterator[str]:
    changed = [each for each in comparison.measurements if each.rising or each.falling]
    if not changed:
        return
    yield "<h2>Measurements</h2>"
    relative = [
        (each.name, each.change / each.before, _relative(each)) for each in changed if abs(each.before) > 0.0
    ][:_MOST_CHANGES]
    if relative:
        chart = _card("Median change, relative to the median before", change_chart(relative))
        yield f'<div class="cards">{chart}</div>'
    yield '<p class="note">Of runs that passed in both campaigns. The repeats of values count as one. '
    yield "The interval is that of the bootstrap, p that of the sign test, adjusted by the method of Holm.</p>"
    yield _table(changed)
    same = len(comparison.measurements) - len(changed)
    yield f'<p class="note">{same:,} measurements did not change.</p>' if same else ""


def _relative(change: MeasurementChange) -> Bounds:
    ends = sorted((change.bounds.low / change.before, change.bounds.high / change.before))
    return Bounds(ends[0], ends[1])


def _table(changes: Sequence[MeasurementChange]) -> str:
    def line(each: MeasurementChange) -> str:
        bounds = f"{number_text(each.bounds.low)} to {number_text(each.bounds.high)}"
        numbers = [number_text(each.before), number_text(each.after), number_text(each.change), bounds]
        texts = [*numbers, str(each.variants), str(each.rising), str(each.falling), p_text(each.p)]
        name = f"<b>{escape(each.name)}</b>" if each.is_significant else escape(each.name)
        cells = "".join(f'<td class="number">{escape(text)}</td>' for text in texts)
        return f"<td>{name}</td>{cells}"

    heads = ["measurement", "before", "after", "change", "95 % interval", "variants", "rising", "falling", "test"]
    return _scroll(heads, map(line, changes))


def _differences(comparison: Comparison) -> Iterator[str]:
    yield "<h2>What differs</h2>"
    if not comparison.differences:
        yield "<p>Files, options and versions are the same.</p>"
        return
    cells = (
        "".join(f"<td>{_short(text)}</td>" for text in (each.name, each.before, each.after))
        for each in comparison.differences
    )
    yield _scroll(["setting or file", "before", "after"], cells)


def _scroll(heads: Sequence[str], lines: Iterator[str] | map[str]) -> str:
    titles = "".join(f"<th>{_short(head)}</th>" for head in heads)
    body = "".join(f"<tr>{line}</tr>\n" for line in lines)
    return f'<div class="scroll"><table><tr>{titles}</tr>{body}</table></div>'


def _card(title: str, content: str) -> str:
    return f'<div class="card"><h3>{_short(title)}</h3>{content}</div>'


def _short(value: object) -> str:
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return escape(text if len(text) <= 300 else text[:299] + "\u2026")
