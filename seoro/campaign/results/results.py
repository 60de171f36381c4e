"""Results of a campaign for programs and notebooks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from seoro.campaign.coverage.unreachable import read_unreachable
from seoro.campaign.results.frame import frame_of
from seoro.campaign.results.html import MOST_ROWS, table_html
from seoro.campaign.results.tally import Tally
from seoro.campaign.state import State
from seoro.campaign.stopping.rate import Rate
from seoro.campaign.store.batches import read_batches
from seoro.campaign.store.folder import CampaignFile, read_campaign
from seoro.campaign.store.index import RowIndex
from seoro.embed.arguments import AnyPath, to_path

if TYPE_CHECKING:
    import pandas

    from seoro.campaign.runs import Row


class Results:
    """Results of a campaign in its folder, also while it runs; see `read`.

    Args:
        folder: Its folder.
        campaign: Content of `campaign.json`: scenario, strategy, number of runs, seed and versions.

    Attributes:
        folder, campaign: As given.
    """

    def __init__(self, folder: Path, campaign: CampaignFile) -> None:
        self.folder = folder
        self.campaign = campaign

    @property
    def tally(self) -> Tally:
        """Number of runs by how they ended."""
        return self._state().tally

    def rate(self) -> Rate:
        """Return the pass rate with its interval, of the runs before the first that has not ended."""
        state = self._state()
        return state.rate(is_complete=state.is_complete)

    def rows(self) -> tuple[Row, ...]:
        """Return the rows of all runs that have ended, by number.

        Raises:
            UsageError: A row is invalid.
        """
        return tuple(RowIndex(self.folder))

    def frame(self) -> pandas.DataFrame:
        """Return a row for each run as a data frame of pandas, with the columns of `runs.csv`.

        Raises:
            UsageError: pandas is not installed, or a row is invalid.
        """
        return frame_of(RowIndex(self.folder))

    def write(self) -> list[Path]:
        """Write `report.html`, `runs.csv`, `test.xml`, and `runs.parquet` if pyarrow is installed.

        Returns:
            The files, the report first.

        Raises:
            UsageError: A row is invalid.
            OSError: A file cannot be written.
        """
        from seoro.campaign.results.files import write_results  # noqa: PLC0415 - not before the first run

        return write_results(self.folder)

    def _state(self) -> State:
        return State(self.campaign, read_batches(self.folder), read_unreachable(self.folder))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.campaign.manifest.shown} in {self.folder}: {self.tally.text}>"

    def _repr_html_(self) -> str:
        """Return counts, pass rate and runs that did not pass for notebooks."""
        title = f"{self.campaign.manifest.shown}: {self.tally.text}. {str(self.rate()).capitalize()}."
        rows = RowIndex(self.folder)
        return table_html(title, list(rows.most_important(MOST_ROWS)), len(rows))


def read(folder: AnyPath) -> Results:
    """Read the results of a campaign.

    Args:
        folder: Its folder.

    Raises:
        UsageError: The folder is not that of a campaign.
    """
    path = to_path("folder", folder)
    return Results(path, read_campaign(path))
