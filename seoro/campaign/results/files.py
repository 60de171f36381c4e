"""Result files of a campaign: `report.html`, `runs.csv`, `runs.parquet`, `test.xml`."""

from __future__ import annotations

from pathlib import Path

from seoro.campaign.report.page import write_report
from seoro.campaign.results.junit import write_junit
from seoro.campaign.results.parquet import write_parquet
from seoro.campaign.results.table import write_table
from seoro.campaign.store.folder import read_campaign
from seoro.campaign.store.index import RowIndex
from seoro.embed.parquet import is_parquet_installed


def write_results(folder: Path) -> list[Path]:
    """Write all results of a campaign, which can be made again at any time.

    Args:
        folder: Its folder.

    Returns:
        The files, the report first. `runs.parquet` is among them if pyarrow is installed.

    Raises:
        UsageError: The folder is not that of a campaign, or a row is invalid.
        OSError: A file cannot be written.
    """
    campaign, rows = read_campaign(folder), RowIndex(folder)
    table = write_table(rows, folder)
    converted = [write_parquet(table)] if is_parquet_installed() else []
    return [write_report(folder), table, *converted, write_junit(rows, folder, campaign)]
