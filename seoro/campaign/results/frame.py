"""Table of the runs as a data frame of pandas, an extra."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.campaign.results.table import columns_of, header, lines_of
from seoro.campaign.store.index import RowIndex
from seoro.errors import UsageError

if TYPE_CHECKING:
    import pandas


def frame_of(rows: RowIndex) -> pandas.DataFrame:
    """Return the table of a campaign, with the columns of `runs.csv`.

    Args:
        rows: Its rows.

    Raises:
        UsageError: pandas is not installed.
    """
    try:
        import pandas  # noqa: PLC0415 - slow to load, and an extra
    except ImportError:
        raise UsageError("a data frame needs pandas", help="pip install 'seoro[pandas]'") from None
    columns = columns_of(rows.batches())
    lines = [line for batch in rows.batches() for line in lines_of(batch, *columns)]
    return pandas.DataFrame(lines, columns=header(*columns))
