"""RoboVAST files as campaign files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from seoro.cli.main import main
from tests.campaign.test_campaigns import table

Write = Callable[[str], str]

SCENARIO = """import osc.helpers

scenario pump:
    pressure: string
    valve: string
    load: float = 0.5
    count: int = 1
    is_wet: bool = false
    do serial:
        log(pressure + " " + valve)
        compare(valve, "!=", "broken")
"""
HEAD = "version: 1\nexecution:\n  runs: 2\n  scenario_file: pump.osc\n"
BATCH = """configuration:
- name: all
  parameters:
  - load: 0.25
  variations:
  - ParameterVariationList:
      name: pressure
      values: [1.5, 2]
  - ParameterVariationList:
      name: [valve, count]
      values: [[ok, 1], [broken, 2]]
- name: drawn
  parameters: [{pressure: 1}, {valve: ok}]
  variations:
  - ParameterVariationDistributionUniform: {name: load, num_variations: 5, min: 0.0, max: 1.0, type: float}
"""
SEARCH = """search:
  strategy: random
  search_space:
    pressure: {type: float, low: 0.5, high: 3.0}
    load: {type: float, low: 0.0, high: 1.0}
    count: {type: int, low: 0, high: 9, step: 3}
    is_wet: {type: bool}
    cracks: {type: choice, values: [0, 2]}
  parameters:
  - valve: ok
  variations:
  - plugins/rust.py:Rust: {cracks: $cracks}
  extract: {plugin: failure_rate}
  objectives: [{name: failure_rate}]
  per_batch: 4
  budget:
  - batches: 3
  - time: {seconds: 90}
  seed: 7
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)
    Path("pump.osc").write_text(SCENARIO)

    def write_file(text: str) -> str:
        Path("study.vast").write_text(text)
        return "study.vast"

    return write_file


def run(file: str, *arguments: str) -> int:
    return main(["campaign", "run", file, "--clock", "virtual", "-j", "1", *arguments])


def test_a_batch_becomes_a_campaign_for_each_configuration(write: Write) -> None:
    assert main(["campaign", "import", write(HEAD + BATCH)]) == 0
    assert run("study_all.yaml") == 1
    rows = table("study_all_results/runs.csv")
    shown = [(row["pressure"], row["valve"], row["count"], row["repeat"], row["status"]) for row in rows]
    together = [("ok", "1", "passed"), ("broken", "2", "failed")]
    assert sorted(shown) == sorted(
        (pressure, valve, count, repeat, status)
        for pressure in ("1.5", "2")
        for valve, count, status in together
        for repeat in ("1", "2")
    )
    assert yaml.safe_load(Path("study_all.yaml").read_text())["set"] == {"load": "0.25"}
    assert run("study_drawn.yaml") == 0
    drawn = table("study_drawn_results/runs.csv")
    assert len(drawn) == 10 and len({row["load"] for row in drawn}) == 5


def test_a_search_varies_numbers_also_of_parameters_with_texts(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", "import", write(HEAD + SEARCH.replace("  - valve: ok\n", "  - count: 1\n"))]) == 0
    assert "write the value of `valve` in study.osc first" in capsys.readouterr().out
    assert main(["campaign", "import", write(HEAD + SEARCH), "--overwrite"]) == 0
    keys = yaml.safe_load(Path("study.yaml").read_text())
    assert keys == {
        "scenario": "study.osc",
        "output_dir": "study_results",
        "seed": 7,
        "strategy": {"random": 24, "repeat": 2},
        "budget": "90.000000s",
    }
    assert run("study.yaml") == 0
    rows = table("study_results/runs.csv")
    assert len(rows) == 24 and {row["count"] for row in rows} <= {"0", "3", "6", "9"}
    assert all(0.5 <= float(row["pressure"]) <= 3.0 for row in rows)


def test_a_search_without_texts_needs_no_other_scenario(write: Write) -> None:
    search = SEARCH.replace("    pressure: {type: float, low: 0.5, high: 3.0}\n", "")
    search = search.replace("    cracks: {type: choice, values: [0, 2]}\n", "")
    search = search.replace("  variations:\n  - plugins/rust.py:Rust: {cracks: $cracks}\n", "")
    assert (
        main(["campaign", "import", write(HEAD + search.replace("valve: ok", "valve: ok\n  - pressure: 1"))]) == 0
    )
    assert not Path("study.osc").exists()
    keys = yaml.safe_load(Path("study.yaml").read_text())
    assert keys["vary"] == ["load in [0.0..1.0]", "count in [0, 3, 6, 9]", "is_wet in [false, true]"]
    assert run("study.yaml") == 0


def test_all_that_is_not_carried_over_is_listed(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = HEAD.replace("  runs: 2\n", "  runs: 1\n  image: ghcr.io/me/pump\n") + SEARCH
    text = text.replace("strategy: random", "strategy: grid_of_mine").replace(
        "high: 1.0}", "high: 1.0, log: true}"
    )
    text = text.replace("{plugin: failure_rate}", "{plugin: read.py:Read}").replace(
        "name: failure_rate", "name: rust"
    )
    text += (
        "  stopping:\n  - no_improvement: 3\n  strategy_parameters: {cells: 3}\nevaluation: {visualization: []}\n"
    )
    assert main(["campaign", "import", write(text)]) == 0
    out = capsys.readouterr().out
    lines = out[out.index("not carried over") :].splitlines()[1:]
    expected = {
        4: "execution.image: runs are processes of this machine",
        7: "grid_of_mine: campaigns have no strategy `grid_of_mine`",
        10: "log of `load`: ranges vary on a linear scale",
        17: "plugins/rust.py:Rust: it computes parameters from `cracks` with Python",
        18: "extract `read.py:Read`: Python does not read results",
        19: "objective `rust`: Python does not extract it from results",
        26: "stopping.no_improvement: campaigns have other stopping rules; limit the runs or the time",
        27: "strategy_parameters.cells: it configures an optimiser of RoboVAST; leave it out",
        28: "evaluation: notebooks are not run",
    }
    found = {int(line.split(":")[1]): line.split(": ", 1)[1] for line in lines if line.startswith("  study.vast")}
    assert found.keys() == expected.keys()
    assert all(found[number].startswith(text) for number, text in expected.items())
    assert all("; " in line for line in found.values()), "each has an advice"
    assert yaml.safe_load(Path("study.yaml").read_text())["strategy"] == {"search": 12, "maximize": "record.rust"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("version: 2\nexecution: {runs: 1}\n", "study.vast:1: version: Input should be 1"),
        ("version: 1\nexecution: {runs: 0}\n", "study.vast:2: execution.runs"),
        (HEAD, "expected `configuration` or `search`"),
        (
            HEAD.replace("pump.osc", "none.osc") + BATCH,
            "study.vast:4: execution.scenario_file: file not found: none.osc",
        ),
        (HEAD + SEARCH.replace("batches: 3", "batches: many"), "study.vast:21: search.budget.0.batches"),
        (HEAD + SEARCH.replace("type: bool", "type: flag"), "search.search_space.is_wet"),
        (HEAD + "configuration: [", "invalid YAML"),
    ],
)
def test_invalid_files_are_refused(
    write: Write, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    assert main(["campaign", "import", write(text)]) == 2
    assert message in capsys.readouterr().err
    assert not list(Path().glob("*.yaml"))


def test_files_of_the_user_are_not_replaced(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    Path("study.yaml").write_text("mine: 1\n")
    file = write(HEAD + SEARCH)
    assert main(["campaign", "import", file]) == 2
    assert "study.yaml exists" in capsys.readouterr().err
    assert not Path("study.osc").exists()
    for _ in range(2):
        assert main(["campaign", "import", file, *(["--overwrite"] if _ == 0 else [])]) == 0


def test_values_that_a_parameter_cannot_have_are_noted(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    batch = BATCH.replace("- load: 0.25", "- load: {a: 1}\n  - lod: 3").replace("values: [1.5, 2]", "values: []")
    batch = batch.replace("[[ok, 1], [broken, 2]]", "[[ok, 1], [broken]]").replace("min: 0.0", "min: low")
    assert main(["campaign", "import", write(HEAD + batch)]) == 0
    out = capsys.readouterr().out
    for text in (
        "set `load`: `load` has another type, float",
        "set `lod`: the scenario has no parameter `lod`",
        "vary `pressure`: `pressure` has another type, string",
        "vary valve, count: expected lists of 2 values",
        "vary `load`: `load` has another type, float",
    ):
        assert text in out
