"""Sections of the report, as HTML."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Final
from urllib.parse import quote

from seoro.campaign.coverage.counts import ItemCounts, failing
from seoro.campaign.report.charts import coverage_bar, floor_of, heat_map, histogram, interval, rate_chart
from seoro.campaign.report.columns import Column, text_of
from seoro.campaign.report.grouping import influence
from seoro.campaign.report.summary import SAMPLE, FailureGroup, Summary
from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.rates import fixed_bounds, live_bounds
from seoro.campaign.stopping.rules import percent
from seoro.campaign.store.folder import CampaignFile
from seoro.campaign.strategies.elites import Elites

MOST_LETTERS: Final = 300  # of a text of a run
_LETTERS: Final = 90  # of a title
_NO_SAMPLE: Final = (
    "This rate estimates no probability: the strategy chose the values, or repeated them. Independent random runs "
    "would have an interval."
)
_BARS: Final = 10
_CELLS: Final = 8  # of a heat map, in each direction
_SHOWN: Final = 6  # charts outside of the folded part
_FAILURES: Final = 20
_ELITES: Final = 100
_MANY: Final = 5  # failures, whose values are hardly alike by chance
_BUCKETS: Final = 8  # of an item, that are shown


def verdict(summary: Summary, campaign: CampaignFile) -> Iterator[str]:
    """Yield the result in one sentence, with the interval of the pass rate."""
    passed, decided = summary.ends[End.PASSED], summary.decided
    is_good = summary.runs > 0 and passed == summary.runs
    yield f'<div class="verdict{"" if is_good else " bad"}">'
    if not decided:
        yield "<b>No run has a verdict.</b>"
    else:
        yield f"<b>{percent(passed / decided)} of {_runs(decided)} passed</b>"
        yield f"{_interval_of(passed, summary, campaign)}."
    without = summary.runs - decided
    others = f" {_runs(without)} ended without a verdict." if without else ""
    yield f"{others}<div class='split'>"
    for end in (End.PASSED, End.FAILED, End.ERROR, End.CANCELLED):
        if summary.ends[end]:
            yield f'<i class="{end.value}" style="flex:{summary.ends[end]} 0 2px"></i>'
    counts = ", ".join(f"{summary.ends[end]:,} {end.value}" for end in End if summary.ends[end])
    excluded = f"; constraints exclude {summary.impossible:,} more" if summary.impossible else ""
    yield f'</div><p class="dim">{counts or "no runs"}{excluded}</p>'
    yield "" if campaign.is_sample else f'<p class="note">{_NO_SAMPLE}</p>'
    yield "</div>"


def _interval_of(passed: int, summary: Summary, campaign: CampaignFile) -> str:
    """Return the interval of the pass rate, which means something for samples only."""
    if not campaign.is_sample:
        return ""
    is_fixed = campaign.has_fixed_runs and campaign.runs == summary.runs
    bounds = (fixed_bounds if is_fixed else live_bounds)(passed, summary.decided)
    return f" (95 % interval{'' if is_fixed else ', valid at any time'}: {interval(bounds)})"


def failures(summary: Summary, folder: Path) -> Iterator[str]:
    """Yield the groups of runs that did not pass, the largest first, each with a command for its first run."""
    groups = sorted(summary.failures.items(), key=lambda item: -item[1].count)
    if not groups:
        return
    yield "<h2>Failures by reason</h2>"
    for (reason, where), group in groups[:_FAILURES]:
        place = f" at <code>{_text(where)}</code>" if where else ""
        yield f'<div class="card wide"><span class="count">{_runs(group.count)}</span>'
        first = group.example
        title = first.reason if group.is_same and first.reason else reason
        yield f"<h3>{_text(title, _LETTERS)}</h3>"
        yield f"<p>{first.status.value.capitalize()}{place}. First: run {first.run}{_link(first)}"
        yield f": {_text(first.reason)}</p>" if first.reason not in (title, "") else "</p>"
        yield from _in_common(group, summary)
        for subcommand in ("replay", "shrink") if first.status is End.FAILED else ("replay",):
            command = shlex.join(["seoro", "campaign", subcommand, str(folder), str(first.run)])
            yield f"<pre>{escape(command)}</pre>"
        yield "</div>"
    rest = groups[_FAILURES:]
    if rest:
        yield f'<p class="note">{_runs(sum(group.count for _, group in rest))} with {len(rest)} other reasons</p>'


def _in_common(group: FailureGroup, summary: Summary) -> Iterator[str]:
    """Yield the values of all or nearly all failures of a group, where they are fewer than those of all runs."""
    texts: dict[int, list[str]] = {}
    for path, values in group.values.items() if group.count >= _MANY else ():
        column = summary.parameters.get(path)
        found = values.narrower_than(column) if column is not None else None
        if found is not None:
            low, high = text_of(found.low), text_of(found.high)
            extent = f"= {low}" if low == high else f"from {low} to {high}"
            texts.setdefault(found.count, []).append(f"{path} {extent}")
    for count in sorted(texts, reverse=True):
        who = "All" if count == group.count else f"{count:,} of {group.count:,}"
        yield f"<p>{who} have {_text(', '.join(texts[count]))}.</p>"


def parameters(summary: Summary) -> Iterator[str]:
    """Yield the pass rate by parameter, and by the pair of parameters that matters most."""
    groupings = {path: column.grouping(_BARS) for path, column in summary.parameters.items()}
    groupings = {path: grouping for path, grouping in groupings.items() if grouping.buckets}
    if not groupings:
        return
    order = sorted(groupings, key=lambda path: -influence(groupings[path].buckets))
    floor = floor_of(bucket for grouping in groupings.values() for bucket in grouping.buckets)
    yield "<h2>Pass rate by parameter</h2>"
    yield '<p class="note">The mark is the pass rate, the bar its 95 % interval, the number passed/runs. '
    yield "Parameters whose values differ most come first. Values are in SI units.</p>"
    charts = [_card(path, rate_chart(groupings[path].buckets, floor)) for path in order]
    if len(order) > 1 and 0 < summary.ends[End.FAILED] < summary.decided:
        charts.insert(2, _pair(summary, *order[:2]))
    yield from _folded(charts, "parameters")


def measurements(summary: Summary) -> Iterator[str]:
    """Yield the histograms of measurements; those whose values go with failures come first."""
    groupings = {name: column.grouping(24) for name, column in summary.measurements.items()}
    groupings = {name: grouping for name, grouping in groupings.items() if len(grouping.buckets) > 1}
    if not groupings:
        return
    yield "<h2>Measurements</h2>"
    order = sorted(groupings, key=lambda name: -influence(groupings[name].buckets))
    notes = {name: _quantiles(summary.measurements[name]) for name in order if groupings[name].is_of_ranges}
    cards = [_card(name, histogram(groupings[name]) + notes.get(name, "")) for name in order]
    yield from _folded(cards, "measurements")


def _quantiles(column: Column) -> str:
    """Return the median and the middle 90 % of a measurement."""
    low, middle, high = (f"{value:.4g}" for value in column.quantiles((0.05, 0.5, 0.95)))
    return f'<p class="note">median {middle}, 90 % from {low} to {high}</p>'


def coverage(summary: Summary) -> Iterator[str]:
    """Yield the coverage of items over all runs, with what lacks samples."""
    items = list(summary.coverage.items.values())
    if not items:
        return
    yield "<h2>Coverage</h2>"
    if summary.coverage.share:
        yield f"<p>{percent(summary.coverage.share)} of all reachable buckets have enough samples.</p>"
    yield '<div class="cards">'
    for item in items:
        yield _card(item.item, "".join(_coverage_of(item)))
    yield "</div>"


def table(summary: Summary) -> Iterator[str]:
    """Yield the runs that did not pass, and those nearest to a limit."""
    rows = [row for _, row in summary.worst]
    if not rows:
        return
    paths = list(dict.fromkeys(path for row in rows for path in row.values))[:_BARS]
    has_margins = any(row.margin is not None for row in rows)
    yield f'<h2>Runs to look at</h2><p class="note">{_runs(len(rows))} that did not pass'
    yield " or have the smallest margins" if has_margins else ""
    yield ". <code>runs.csv</code> has all runs.</p>"
    titles = ["run", "status", "seed", *paths, *(["margin"] if has_margins else []), "reason", "place"]
    heads = "".join(f"<th>{_text(title, _LETTERS)}</th>" for title in titles)
    yield f'<div class="scroll"><table><tr>{heads}</tr>'
    for row in rows:
        margin = [_cell(row.margin)] if has_margins else []
        cells = [_cell(row.seed), *(_cell(row.values.get(path)) for path in paths), *margin]
        status = row.status.value
        yield f'<tr><td class="number">{row.run}{_link(row)}</td><td class="{status}">{status}</td>'
        yield "".join(cells)
        yield f'<td class="reason">{_text(row.reason)}</td><td>{_text(row.where)}</td></tr>\n'
    yield "</table></div>"


def elites(found: Elites) -> Iterator[str]:
    """Yield the worst run of each kind."""
    shown = found.elites[:_ELITES]
    if not shown:
        return
    kinds = f"{len(found.elites):,} kinds" if len(found.elites) > 1 else "1 kind"
    most = f"; {len(shown)} are shown" if len(shown) < len(found.elites) else ""
    yield '<h2>Worst run of each kind</h2><p class="note">'
    yield f"{kinds} of runs, by {_text(' and '.join(found.titles))}{most}, the worst first.</p>"
    paths = list(dict.fromkeys(path for each in shown for path in each.row.values))[:_BARS]
    titles = [*found.titles, "run", "status", found.column, *paths]
    heads = "".join(f"<th>{_text(title, _LETTERS)}</th>" for title in titles)
    yield f'<div class="scroll"><table><tr>{heads}</tr>'
    for kind, row, value in shown:
        status = row.status.value
        yield f"<tr>{''.join(map(_cell, kind))}"
        yield f'<td class="number">{row.run}{_link(row)}</td><td class="{status}">{status}</td>'
        yield f"{_cell(value)}{''.join(_cell(row.values.get(path)) for path in paths)}</tr>\n"
    yield "</table></div>"


def making(summary: Summary, campaign: CampaignFile) -> Iterator[str]:
    """Yield the settings of the campaign, and where and when it ran."""
    hosts = ", ".join(f"{host} ({count:,})" for host, count in summary.hosts.most_common(10) if host)
    options = ", ".join(f"{name} {value}" for name, value in campaign.strategy.options.items())
    facts = {
        "Scenario": campaign.manifest.shown,
        **({"Requirements": ", ".join(campaign.requirements)} if campaign.requirements else {}),
        "Strategy": f"{campaign.strategy.name}{f' ({options})' if options else ''}, seed {campaign.seed}",
        "Repeats": str(campaign.repeat),
        "Simulator": campaign.simulator or "none",
        "Runs": f"{summary.runs:,} of {campaign.runs:,}" if campaign.runs is not None else f"{summary.runs:,}",
        "Processor time": f"{summary.cpu:,.1f} s",
        "Started": f"{_time(summary.first)} to {_time(summary.last)} UTC" if summary.first else "unknown",
        "Machines": hosts or "unknown",
        "Version": f"seoro {campaign.version}",
        "Fingerprint": campaign.digest[:16],
    }
    yield '<h2>Settings and machines</h2><div class="card"><dl>'
    yield from (f"<dt>{name}</dt><dd>{_text(fact)}</dd>" for name, fact in facts.items())
    yield "</dl></div>"


def _pair(summary: Summary, vertical: str, horizontal: str) -> str:
    rows, columns = (summary.parameters[path].grouping(_CELLS) for path in (vertical, horizontal))
    cells = [[[0, 0] for _ in columns.buckets] for _ in rows.buckets]
    for values, has_failed in summary.sample.items:
        row, column = rows.index_of(values.get(vertical)), columns.index_of(values.get(horizontal))
        if row is not None and column is not None:
            cells[row][column][has_failed] += 1
    sampled = summary.decided > SAMPLE
    of = f" From {SAMPLE:,} runs, drawn at random." if sampled else ""
    note = f'<p class="note">Share of failures in percent; framed cells have no run.{of}</p>'
    frozen = [[(passed, failed) for passed, failed in line] for line in cells]
    return _card(f"{vertical} (down) and {horizontal} (across)", heat_map(rows, columns, frozen) + note)


def _coverage_of(item: ItemCounts) -> Iterator[str]:
    samples = f"at least {_samples(item.needed)}"
    if item.reachable:
        yield coverage_bar(item.reached, item.reachable)
        yield f"<p>{item.reached:,} of {item.reachable:,} buckets with {samples}</p>"
        holes = item.holes
        if holes:
            yield f'<p class="note">Lacking: {_some(holes, item.unit)}</p>'
        elif item.reached < item.reachable:
            yield f'<p class="note">{item.reachable - item.reached:,} are lacking</p>'
    elif item.buckets:
        yield f"<p>{len(item.buckets):,}{' or more' if item.is_cut else ''} different values</p>"
    else:
        yield "<p>no samples</p>"
    yield from _unreachable_in(item)
    low = sorted(item.buckets.items(), key=lambda each: each[1].samples)[:5]
    if low:
        shown = ", ".join(f"{bucket}: {counts.samples:,}" for bucket, counts in low)
        yield f'<p class="note">Fewest samples: {_text(shown)}</p>'
    for bucket, counts in failing(item)[:_BUCKETS]:
        yield f'<p class="note">{_text(bucket)}: {counts.failed:,} of {_runs(counts.runs)} failed</p>'
    if item.illegal:
        yield f'<p class="count">{item.illegal:,} illegal</p>'
    if item.outside:
        yield f'<p class="note">{_samples(item.outside)} outside of all buckets</p>'


def _unreachable_in(item: ItemCounts) -> Iterator[str]:
    """Yield the buckets that constraints exclude, by these constraints."""
    for reasons, buckets in item.excluded.items():
        by = f" by {' and '.join(reasons)}" if reasons else ""
        yield f'<p class="note">Unreachable{_text(by)}: {_some(buckets, item.unit)}</p>'


def _some(buckets: Sequence[str], unit: str) -> str:
    more = f" and {len(buckets) - _BUCKETS:,} more" if len(buckets) > _BUCKETS else ""
    return _text(f"{', '.join(buckets[:_BUCKETS])}{more}{f' {unit}' if unit else ''}")


def _folded(charts: Sequence[str], of: str) -> Iterator[str]:
    yield f'<div class="cards">{"".join(charts[:_SHOWN])}</div>'
    if len(charts) > _SHOWN:
        yield f"<details><summary>{len(charts) - _SHOWN} more {of}</summary>"
        yield f'<div class="cards">{"".join(charts[_SHOWN:])}</div></details>'


def _card(title: str, content: str) -> str:
    return f'<div class="card"><h3>{_text(title, _LETTERS)}</h3>{content}</div>'


def _link(row: Row) -> str:
    return f' <a href="{escape(quote(row.folder, errors="replace"))}/">files</a>' if row.folder else ""


def _cell(value: object) -> str:
    style = ' class="number"' if isinstance(value, int | float) else ""
    return f"<td{style}>{_text('' if value is None else text_of(value))}</td>"


def _text(text: str, most: int = MOST_LETTERS) -> str:
    return escape(text if len(text) <= most else text[: most - 1] + "\u2026")


def _time(text: str) -> str:
    return text[:19].replace("T", " ")


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count:,} runs"


def _samples(count: int) -> str:
    return "1 sample" if count == 1 else f"{count:,} samples"
