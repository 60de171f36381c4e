"""The table of a campaign as Parquet."""

from pathlib import Path

import pytest

from seoro.campaign.results.parquet import write_parquet

parquet = pytest.importorskip("pyarrow.parquet")


def test_types_follow_from_all_values(tmp_path: Path) -> None:
    table = tmp_path / "runs.csv"
    many = "".join(f"{number},{number}\n" for number in range(200_000))  # more than one block
    table.write_text(f"run,load\n{many}200000,0.5\n")
    read = parquet.read_table(write_parquet(table))
    assert read.num_rows == 200_001
    assert str(read.schema.field("load").type) == "double" and read["load"][-1].as_py() == 0.5
