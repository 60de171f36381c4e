from __future__ import annotations

from argparse import Namespace
from importlib.util import find_spec
from pathlib import Path

import pytest

from seoro.bridges.wire import Artifact
from seoro.cli.main import main
from seoro.cli.results import ResultFiles
from seoro.runtime.verdict import RunStatus, Verdict


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wait.osc").write_text("import osc.types\n\nscenario main:\n    do wait elapsed(1s)\n")


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is not installed")
def test_tables_are_also_written_as_parquet() -> None:
    from pyarrow import parquet

    table = Artifact(
        name="trajectories.csv", media_type="text/csv", description="poses", data=b"time,entity,x\n0.1,cart,\n"
    )
    other = table.model_copy(update={"name": "else.csv"})
    options = Namespace(output_dir=Path("out"), trace=None, junit=None, parquet=True, report=False)
    verdict = Verdict(RunStatus.PASSED, "", None, 1.0, 1.0, 0, "main", "wait.osc")
    written = ResultFiles(options).write(verdict, {}, "", [table, other])
    assert (Path("out/trajectories.parquet"), "poses, as Parquet") in written
    assert not Path("out/else.parquet").exists()
    read = parquet.read_table("out/trajectories.parquet").to_pylist()
    assert read == [{"time": 0.1, "entity": "cart", "x": None}]


def test_without_pyarrow_a_note_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("seoro.embed.parquet.find_spec", lambda name: None)
    assert main(["exec", "wait.osc", "--clock", "virtual", "-o", "out", "--parquet"]) == 0
    assert capsys.readouterr().err.count("pip install 'seoro[parquet]'") == 1


def test_parquet_needs_an_output_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "wait.osc", "--parquet"]) == 2
    assert "`--parquet` needs an output folder" in capsys.readouterr().err
