"""Table of the runs as a data frame of pandas, an extra."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from seoro.campaign.results.table import cells, columns_of, header
from seoro.campaign.runs import Row
from seoro.errors import UsageError

if TYPE_CHECKING:
    import pandas


def frame_of(rows: Sequence[Row]) -> pandas.DataFrame:
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
    columns = columns_of(rows)
    return pandas.DataFrame([cells(row, *columns) for row in rows], columns=header(*columns))
