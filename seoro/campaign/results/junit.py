"""The runs as JUnit XML, for CI servers."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from seoro.campaign.runs import Row, title_of
from seoro.campaign.store.folder import CampaignFile
from seoro.campaign.store.index import RowIndex
from seoro.runtime.trace.junit import TAGS, Case, junit
from seoro.runtime.verdict import RunStatus

JUNIT: Final = "test.xml"
MOST_CASES: Final = 10_000  # of runs that did not pass, then of others


def write_junit(rows: RowIndex, folder: Path, campaign: CampaignFile) -> Path:
    """Write the JUnit file of a campaign, with at most `MOST_CASES` runs: CI servers fail at larger files.

    Args:
        rows: Its rows.
        folder: Its folder.
        campaign: Content of its `campaign.json`.
    """
    path = folder / JUNIT
    path.write_text(junit([_case(row, campaign) for row in rows.most_important(MOST_CASES)]), encoding="utf-8")
    return path


def _case(row: Row, campaign: CampaignFile) -> Case:
    texts = {name: str(value) for name, value in row.values.items()}
    return Case(
        name=f"{row.run}: {title_of(texts)}",
        file=campaign.manifest.shown,
        tag=TAGS.get(RunStatus(row.status.value)),
        kind=row.status.value,
        message=row.reason,
        text=f"{row.where}: {row.reason}" if row.where else row.reason,
        duration=row.wall_duration,
        properties={
            "seed": row.seed,
            "duration": row.duration,
            **{f"parameter.{path}": value for path, value in row.values.items()},
        },
        requirements=campaign.requirements,
    )
