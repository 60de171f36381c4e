"""The report as a file: `report.html`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Final

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.unreachable import read_unreachable
from seoro.campaign.report import sections
from seoro.campaign.report.findings import findings
from seoro.campaign.report.style import STYLE
from seoro.campaign.report.summary import Summary, summarize
from seoro.campaign.store.batches import read_batches
from seoro.campaign.store.folder import CampaignFile, read_campaign
from seoro.campaign.store.index import RowIndex
from seoro.campaign.strategies.choice import make_strategy
from seoro.campaign.strategies.elites import elites_of
from seoro.campaign.strategies.map_elites import MapElites

REPORT: Final = "report.html"
_CONTROLS: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff]")  # invalid in HTML, or not UTF-8


def write_report(folder: Path) -> Path:
    """Write the report of a campaign.

    Args:
        folder: Folder of the campaign.

    Returns:
        The report.

    Raises:
        UsageError: The folder is not that of a campaign, or a row is invalid.
        OSError: The report cannot be written.
    """
    campaign = read_campaign(folder)
    coverage = MergedCoverage(campaign.items, read_unreachable(folder))
    summary = summarize(read_batches(folder), campaign.seed, coverage)
    text = "".join(page(summary, campaign, folder))
    path = folder / REPORT
    path.write_text(without_controls(text), encoding="utf-8")
    return path


def without_controls(text: str) -> str:
    """Replace characters that are invalid in HTML or UTF-8."""
    return _CONTROLS.sub("\ufffd", text)


def page(summary: Summary, campaign: CampaignFile, folder: Path) -> Iterator[str]:
    """Yield the parts of the page.

    Args:
        summary: Summary of the rows.
        campaign: Content of `campaign.json`.
        folder: Folder of the campaign.
    """
    title = escape(campaign.manifest.shown)
    yield '<!doctype html><html lang="en"><head><meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width,initial-scale=1">'
    yield f"<title>{title}: campaign</title><style>{STYLE}</style></head><body>"
    yield f"<h1>{title}</h1>"
    yield from sections.verdict(summary, campaign)
    yield from sections.failures(summary, folder)
    yield from findings(folder)
    if campaign.strategy.name == MapElites.name:
        yield from _elites(campaign, folder)
    yield from sections.parameters(summary)
    yield from sections.measurements(summary)
    yield from sections.coverage(summary)
    yield from sections.table(summary)
    yield from sections.making(summary, campaign)
    yield "</body></html>\n"


def _elites(campaign: CampaignFile, folder: Path) -> Iterator[str]:
    """Yield the worst run of each kind, in another pass over the rows."""
    strategy, index = make_strategy(campaign.strategy), RowIndex(folder)
    assert isinstance(strategy, MapElites), "by its name"
    found = elites_of(strategy, [each.item for each in campaign.items], index.__iter__)
    if found is not None:
        yield from sections.elites(found)
