"""Campaign files: options of `seoro campaign run` as YAML."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.cli.arguments import Parser
from seoro.cli.campaign_command import add_arguments
from seoro.cli.campaign_file import PATHS
from seoro.cli.main import main
from tests.campaign.test_campaigns import TEXT, table

Write = Callable[[str], str]


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "main.osc").write_text(TEXT.format(pause="1h"))

    def write_file(text: str) -> str:
        Path("sub/study.yaml").write_text("scenario: main.osc\n" + text)
        return "sub/study.yaml"

    return write_file


def listed(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[str]:
    """Return the planned runs of a campaign."""
    assert main(["campaign", "run", *arguments, "--list"]) == 0
    return [line for line in capsys.readouterr().out.splitlines() if line[:1].isdigit()]


def test_a_campaign_file_runs_and_resumes_by_itself(write: Write) -> None:
    file = write("clock: virtual\nseed: 5\nset: {noise: 0.0}\nstrategy: {grid: 2, repeat: 2}\noutput_dir: out\n")
    assert main(["campaign", "run", file, "-j", "1"]) == 0
    rows = table("sub/out/runs.csv")
    assert len(rows) == 8 and {row["seed"] for row in rows} == {"5", "6"}
    assert main(["campaign", "resume", "sub/out", "--runs", "8"]) == 0
    kept = json.loads(Path("sub/out/campaign.json").read_text())
    assert kept["strategy"] == {"name": "grid", "options": {"levels": 2}}


def test_options_replace_those_of_the_file(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(
        "seed: 5\nstrategy: {pairwise: 2, levels: 2, repeat: 2}\nvary: 'shift in [0.2, 0.4]'\nset: {way: 1m}\n"
    )
    assert listed(capsys, file)[:2] == [
        "1  noise=0.0 shift=0.2  seed 5", "2  noise=0.0 shift=0.2  seed 6"
    ]  # fmt: skip
    before = listed(capsys, "--repeat", "1", "--seed", "7", file, "--set", "noise=0.2", "--strategy", "grid")
    assert before == ["1  shift=0.2  seed 7", "2  shift=0.4  seed 7"]
    replaced = listed(capsys, file, "--vary", "shift in [0.5]", "--set", "noise=0.2", "--repeat", "1")
    assert replaced == ["1  shift=0.5  seed 5"]
    assert main(["campaign", "run", write("simulator: mujoco\n"), "--connect", "tcp/127.0.0.1:1", "-j", "2"]) == 2
    assert "runs on one simulator are sequential" in capsys.readouterr().err


def test_paths_are_relative_to_the_file(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    Path("sub/hall.yaml").write_text("nothing: 1\n")
    file = write("simulator: {name: mujoco, world: hall.yaml, rate: max}\nset: {noise: 0.0}\noutput_dir: out\n")
    assert main(["campaign", "run", file, "-j", "1"]) == 2
    assert "sub/hall.yaml:1: nothing: unknown key `nothing`" in capsys.readouterr().err


def test_all_options_for_paths_are_known() -> None:
    parser = Parser(prog="seoro campaign")
    add_arguments(parser)
    commands = next(each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
    options = [each for each in commands.choices["run"]._actions if each.type is Path]
    long = {each.option_strings[-1].removeprefix("--") for each in options}
    assert long - {"emit", "keys"} == set(PATHS)


def test_rules_are_a_text_a_list_or_a_mapping(write: Write) -> None:
    common = "clock: virtual\nseed: 5\nset: {noise: 0.0}\nstrategy: {random: 40}\noutput_dir: out\n"
    for until, expected in (
        ("{rate: 0.9, against: 0.5, errors: 0.1}", ["rate >= 0.9 vs 0.5 errors 0.1"]),
        ("first failure", ["first failure"]),
        ("[first failure, rate +- 20%]", ["first failure", "rate +- 20%"]),
    ):
        main(["campaign", "run", write(f"{common}until: {until}\n"), "-j", "1", "--overwrite"])
        assert json.loads(Path("sub/out/campaign.json").read_text())["until"] == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("repat: 3", ":2: unknown option `--repat` of `seoro campaign run`"),
        ("seed: 1\nrepeat: x", ":3: argument --repeat: expected a whole number from 1, found 'x'"),
        (
            "strategy: gird",
            ":2: strategy: expected the name of one strategy, found `gird`\n  = help: did you mean `grid`",
        ),
        ("strategy: {grid: 2, sobol: 4}", "found `grid` and `sobol`"),
        ("strategy: {pairwise: 2, lvels: 3}", ":2: unknown option `--lvels`"),
        ("strategy: {random: 3}\nruns: 4", ":3: duplicate option `runs`, first at sub/study.yaml:2"),
        ("until: {rate: 0.9, gainst: 0.3}", "did you mean `against`?"),
        ("until: never", ":2: invalid stopping rule `never`"),
        ("simulator: {nme: mujoco}", ":2: simulator.nme: unknown key `nme` (did you mean `name`?)"),
        ("sim: mujoco", ":2: unknown key `sim`\n  = help: write `simulator: {name: ...}`"),
        ("overwrite: true", "add `--overwrite` to the command"),
        ("seed: {a: 3}", ":2: seed: Value error, expected a text, a number, true or false"),
        ("parquet: 3", ":2: argument --parquet"),
        ("scenario: other.osc", "duplicate key 'scenario'"),
        ("set: [", "invalid YAML"),
    ],
)
def test_mistakes_are_shown_with_their_line(
    write: Write, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    try:
        status = main(["campaign", "run", write(text)])
    except SystemExit as refused:
        status = int(str(refused.code))
    assert status == 2
    assert message in capsys.readouterr().err


def test_a_missing_scenario_is_shown_with_its_line(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write("")
    Path("sub/main.osc").unlink()
    assert main(["campaign", "run", file]) == 2
    assert "sub/study.yaml:1: scenario: file not found: sub/main.osc" in capsys.readouterr().err
