"""Charts as inline SVG; colours come from the style sheet of the page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Final

from seoro.campaign.report.grouping import Bucket, Grouping
from seoro.campaign.statistics.rates import Bounds, fixed_bounds
from seoro.campaign.stopping.rules import percent

WIDTH: Final = 330  # a chart fills a telephone; text stays readable
_LABEL: Final = 112  # width of labels
_COUNT: Final = 72
_LINE: Final = 22
_LETTERS: Final = 16  # of a label
_NAMED: Final = 3  # values, for whose labels there is space


def rate_chart(buckets: Sequence[Bucket], floor: float) -> str:
    """Return a chart of pass rates: a mark for each group, on a bar for its 95 % interval.

    Args:
        buckets: The groups; those without a run are left out.
        floor: Rate at the left end of the axis; the right end is 1.
    """
    used = [bucket for bucket in buckets if bucket.runs]
    left, right = _LABEL + 6.0, WIDTH - _COUNT - 6.0
    height = _LINE * len(used) + 24

    def x(rate: float) -> float:
        return left + (right - left) * (max(rate, floor) - floor) / (1.0 - floor)

    parts = []
    for rate in (floor, 1.0):
        parts.append(f'<path class="grid" d="M{x(rate):.1f} 0V{height - 20}"/>')
        parts.append(_text(x(rate), height - 6, percent(rate), "middle", "dim"))
    for number, bucket in enumerate(used):
        y, bounds, rate = number * _LINE, fixed_bounds(bucket.passed, bucket.runs), bucket.passed / bucket.runs
        title = f"{bucket.label}: {bucket.passed:,} of {bucket.runs:,} passed, {interval(bounds)}"
        low, high = x(bounds.low), x(bounds.high)
        parts.append(
            f"<g><title>{escape(title)}</title>{_text(_LABEL, y + 15, shorten(bucket.label), 'end')}"
            f'<rect class="range" {_box(low, y + 5, max(high - low, 1.0), 12)} rx="3"/>'
            f'<rect class="mark" {_box(x(rate) - 2, y + 2, 4, 18)} rx="2"/>'
            f"{_text(WIDTH - 2, y + 15, count_of(bucket), 'end', 'dim')}</g>"
        )
    return _svg(height, parts, "Pass rate by value")


def heat_map(rows: Grouping, columns: Grouping, cells: Sequence[Sequence[tuple[int, int]]]) -> str:
    """Return a map of the share of failures for pairs of groups; the cell with the largest share is darkest.

    Args:
        rows: Groups of the parameter from top to bottom.
        columns: Groups of the parameter from left to right.
        cells: Runs that passed and failed, by row and column.
    """
    side = min((WIDTH - _LABEL - 6.0) / len(columns.buckets), 44.0)
    tall, top = min(side, 34.0), _LABEL + 6.0
    bottom = tall * len(rows.buckets)
    most = max((failed / (passed + failed) for line in cells for passed, failed in line if failed), default=1.0)
    parts = []
    for row, (bucket, line) in enumerate(zip(rows.buckets, cells, strict=True)):
        parts.append(_text(_LABEL, row * tall + tall / 2 + 4, shorten(bucket.label), "end"))
        for column, (passed, failed) in enumerate(line):
            runs = passed + failed
            share = failed / runs if runs else 0.0
            shown = f"{failed:,} of {runs:,} failed" if runs else "no run"
            title = escape(f"{bucket.label}, {columns.buckets[column].label}: {shown}")
            box = _box(top + column * side, row * tall, side - 1, tall - 1)
            inside = f'<rect class="failed" {box} fill-opacity="{share / most:.3f}"/>' if share else ""
            number = ""
            if side >= 26.0 and runs:
                style = "on" if share > 0.6 * most else ""
                number = _text(
                    top + (column + 0.5) * side,
                    row * tall + tall / 2 + 4,
                    f"{100 * share:.2g}" if share < 1 else "100",
                    "middle",
                    style,
                )
            parts.append(
                f'<g><title>{title}</title><rect class="{"cell" if runs else "none"}" {box}/>{inside}{number}</g>'
            )
    for column, bucket in enumerate(columns.buckets):
        x, y = top + (column + 0.5) * side + 4, bottom + 6
        parts.append(
            f'<text transform="translate({x:.1f} {y:.1f}) rotate(-90)" text-anchor="end">'
            f"{escape(shorten(bucket.label))}</text>"
        )
    longest = max(len(shorten(bucket.label)) for bucket in columns.buckets)
    return _svg(bottom + 14 + 6.6 * longest, parts, "Share of failures by two parameters, in percent")


def histogram(grouping: Grouping) -> str:
    """Return a histogram with two rows: runs that passed above the axis, runs that failed below it.

    Both have their own scale, so that few failures stay visible.
    """
    buckets = grouping.buckets
    wide, tall, top = (WIDTH - 8.0) / len(buckets), 62.0, 16.0
    most_passed = max(bucket.passed for bucket in buckets) or 1
    most_failed = max(bucket.failed for bucket in buckets) or 1
    parts = []
    for number, bucket in enumerate(buckets):
        x, width = 4 + number * wide, max(min(wide - 1.0, 60.0), 1.0)
        up, down = tall * bucket.passed / most_passed, tall * bucket.failed / most_failed
        title = escape(f"{bucket.label}: {bucket.passed:,} passed, {bucket.failed:,} failed")
        bar = x + (wide - width) / 2
        parts.append(
            f'<g><title>{title}</title><rect class="hit" {_box(x, top, wide, 2 * tall + 2)}/>'
            f'<rect class="passed" {_box(bar, top + tall - up, width, up)}/>'
            f'<rect class="failed" {_box(bar, top + 2 + tall, width, down)}/></g>'
        )
    bottom = top + 2 * tall + 16
    parts.append(f'<path class="grid" d="M4 {top + 1 + tall}H{WIDTH - 4}"/>')
    parts.append(_text(WIDTH - 4, 9, f"passed, at most {most_passed:,}", "end", "dim"))
    parts.extend(_values(buckets, wide, bottom))
    below = sum(bucket.failed for bucket in buckets)
    note = f"failed, at most {most_failed:,}" if below else "none failed"
    parts.append(_text(WIDTH - 4, bottom + 15, note, "end", "dim"))
    return _svg(bottom + 21, parts, "Number of runs by value")


def _values(buckets: Sequence[Bucket], wide: float, y: float) -> Iterator[str]:
    """Yield the labels of an axis: of each of a few values, or of both ends."""
    if len(buckets) <= _NAMED and buckets[0].low is None:
        for number, bucket in enumerate(buckets):
            yield _text(4 + (number + 0.5) * wide, y, _end_of(bucket, None), "middle")
        return
    yield _text(4, y, _end_of(buckets[0], buckets[0].low), "start")
    yield _text(WIDTH - 4, y, _end_of(buckets[-1], buckets[-1].high), "end")


def change_chart(changes: Sequence[tuple[str, float, Bounds]]) -> str:
    """Return a chart of relative changes: a mark for each, on a bar for its interval. The line is at zero.

    Args:
        changes: Label, change and interval of each, as shares of the value before.
    """
    left, right = _LABEL + 6.0, WIDTH - _COUNT - 6.0
    most = max((max(abs(bounds.low), abs(bounds.high)) for _, _, bounds in changes), default=0.0) or 1.0
    height = _LINE * len(changes) + 24

    def x(share: float) -> float:
        return (left + right) / 2 + (right - left) / 2 * share / most

    parts = [f'<path class="grid" d="M{x(0.0):.1f} 0V{height - 20}"/>']
    for share in (-most, 0.0, most):
        parts.append(_text(x(share), height - 6, f"{100 * share:+.3g} %", "middle", "dim"))
    for number, (label, share, bounds) in enumerate(changes):
        y, low, high = number * _LINE, x(bounds.low), x(bounds.high)
        title = f"{label}: {100 * share:+.3g} % ({100 * bounds.low:+.3g} to {100 * bounds.high:+.3g} %)"
        parts.append(
            f"<g><title>{escape(title)}</title>{_text(_LABEL, y + 15, shorten(label), 'end')}"
            f'<rect class="range" {_box(low, y + 5, max(high - low, 1.0), 12)} rx="3"/>'
            f'<rect class="mark" {_box(x(share) - 2, y + 2, 4, 18)} rx="2"/>'
            f"{_text(WIDTH - 2, y + 15, f'{100 * share:+.3g} %', 'end', 'dim')}</g>"
        )
    return _svg(height, parts, "Relative change of measurements")


def coverage_bar(reached: int, total: int) -> str:
    """Return a bar for the share of buckets that have enough samples."""
    width = (WIDTH - 2.0) * min(reached / total, 1.0)
    parts = [
        f'<rect class="none" x="1" y="2" width="{WIDTH - 2}" height="12" rx="3"/>',
        f'<rect class="passed" x="1" y="2" width="{width:.1f}" height="12" rx="3"/>',
    ]
    return _svg(16, parts, f"{reached} of {total} buckets")


def floor_of(buckets: Iterable[Bucket]) -> float:
    """Return the left end of the axis for pass rates: 0, or 10 % below which no interval reaches."""
    lowest = min((fixed_bounds(each.passed, each.runs).low for each in buckets if each.runs), default=0.0)
    return 0.0 if lowest < 0.5 else int(lowest * 10.0) / 10.0 if lowest < 0.9 else int(lowest * 100.0) / 100.0


def interval(bounds: Bounds) -> str:
    """Return an interval, for people."""
    return f"{percent(bounds.low)} to {percent(bounds.high)}"


def count_of(bucket: Bucket) -> str:
    """Return the failures and runs of a group, shortened."""
    return f"{_short(bucket.passed)}/{_short(bucket.runs)}"


def shorten(text: str) -> str:
    """Cut a long label."""
    return text if len(text) <= _LETTERS else text[: _LETTERS - 1] + "\u2026"


def _end_of(bucket: Bucket, edge: float | None) -> str:
    return shorten(bucket.label) if edge is None else f"{edge:.6g}"


def _short(count: int) -> str:
    if count < 10_000:
        return str(count)
    return f"{count / 1000:.0f}k" if count < 1_000_000 else f"{count / 1e6:.1f}M"


def _box(x: float, y: float, width: float, height: float) -> str:
    return f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'


def _text(x: float, y: float, text: str, anchor: str, style: str = "") -> str:
    named = f' class="{style}"' if style else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{named}>{escape(text)}</text>'


def _svg(height: float, parts: Iterable[str], title: str) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img" aria-label="{escape(title)}">{"".join(parts)}</svg>'
    )
