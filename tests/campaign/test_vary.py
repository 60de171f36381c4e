"""Parameters that vary by an option: `--vary`."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.campaign.test_campaigns import table

TEXT = """import osc.types
import osc.helpers

scenario greet:
    volume: float
    keep(volume < 5.0)
    do log("hello")

scenario main:
    pace: speed
    keep(default pace == 1mps)
    number: int
    keep(number in [1..9])
    do serial:
        greet(2.0)
        last: greet()
        wait elapsed(1s)
"""
COMMAND = ("campaign", "run", "main.osc", "--clock", "virtual", "--seed", "1", "-j", "1", "-o", "out")


@pytest.fixture(autouse=True)
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)


def test_parameters_of_the_scenario_and_of_invocations_vary_by_an_option() -> None:
    varied = ["--vary", "pace in [1mps, 2mps]", "--vary", "last.volume in [1.0, 2.0]"]
    assert main([*COMMAND, *varied, "--constrain", "number == 3"]) == 0
    found = [(row["pace"], row["last.volume"]) for row in table()]
    assert found == [("1.0", "1.0"), ("1.0", "2.0"), ("2.0", "1.0"), ("2.0", "2.0")]
    assert main(["campaign", "resume", "out", "-j", "1"]) == 0


def test_an_option_narrows_a_range_of_the_scenario() -> None:
    varied = ["--vary", "number in [8..20]", "--vary", "last.volume in [1.0..2.0]"]
    assert main([*COMMAND, *varied, "--strategy", "random", "--runs", "12"]) == 0
    assert {row["number"] for row in table()} == {"8", "9"}
    assert all(1.0 <= float(row["last.volume"]) <= 2.0 for row in table())


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("--vary=pac in [1mps..2mps]", "did you mean `pace`?"),
        ("--vary=last.volum in [1.0..2.0]", "did you mean `volume`?"),
        ("--vary=pace > 2mps", "`pace > 2mps` makes no parameter vary"),
        ("--vary=number in [10..20]", "the constraints of `number` leave no value"),
        ("--vary=pace in [1mps, 2mps", "`[` is not closed"),
        ("--strategy=random", "the strategy `random` has no last run"),
        ("--strategy=search", "the strategy `search` has no last run"),
    ],
)
def test_invalid_options_are_refused(option: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*COMMAND, option]) == 2
    assert message in capsys.readouterr().err
    assert not Path("out").exists()


def test_a_single_run_takes_constraints_and_repeats_them(capsys: pytest.CaptureFixture[str]) -> None:
    run = ["main.osc", "--clock", "virtual", "--seed", "1"]
    limits = ["--constrain", "pace in [2mps..3mps]", "--constrain", "last.volume in [1.0..1.5]"]
    assert main(["exec", *run, *limits, "-o", "once"]) == 0
    first = Path("once/trace.jsonl").read_text().splitlines()[0]
    assert '"constraints": ["pace in [2mps..3mps]", "last.volume in [1.0..1.5]"]' in first
    assert main(["replay", "once/trace.jsonl", "main.osc", "-o", "again"]) == 0
    assert '"last.volume in [1.0..1.5]"' in Path("again/trace.jsonl").read_text().splitlines()[0]
