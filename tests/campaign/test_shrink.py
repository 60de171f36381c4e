"""Failed runs, made as simple as possible."""

import asyncio
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import seoro.campaign as sc
from seoro.campaign.after.around import repeats_for
from seoro.campaign.after.finding import FoundRun
from seoro.campaign.after.ladders import Ladder, ladder_of, simplest_of, step_of
from seoro.campaign.after.same_failure import SameFailure, values_of_run
from seoro.campaign.after.shrinking import Outcome, Shrinking
from seoro.campaign.report.page import write_report
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.store.folder import read_campaign
from seoro.campaign.strategies.contract import Told
from seoro.cli.main import main
from seoro.embed.options import Lab, Options, Ros, Simulator
from tests.campaign.generated import generate
from tests.campaign.shrunk import FAILURE, SIMPLE, SPACE, carry_out, planted, told
from tests.campaign.spaces import SPAN, listed, ranged
from tests.campaign.test_campaigns import table

MOST = 60  # runs, as wanted for five parameters of which two matter


@pytest.mark.parametrize("seed", range(60))
def test_a_planted_failure_becomes_minimal_in_few_runs(seed: int) -> None:
    fails, values = planted(seed)
    shrinking = Shrinking(7, values, FAILURE)
    ran = carry_out(shrinking, fails)
    found = shrinking.values
    assert shrinking.outcome is Outcome.MINIMAL and len(ran) <= MOST
    assert fails(found) and found.items() >= SIMPLE.items()
    assert ran[0].values == values and all(point.parent == 7 for point in ran)
    one_step = {"a": str(int(found["a"]) - 1), "load": f"{float(found['load']) - 0.01:.4g}"}
    for path, text in one_step.items():
        assert float(found[path]) == 0.0 or not fails({**found, path: text}), "one step simpler does not fail"


def within(least: float, most: float, values: Mapping[str, str]) -> bool:
    return least < float(values["load"]) < most


def test_digits_are_as_few_as_the_failure_allows() -> None:
    for least, most, text in ((0.731, 2.0, "0.74"), (0.731, 0.7399, "0.732"), (0.73141, 0.73142, "0.731411")):
        shrinking = Shrinking(1, {"load": "0.731415"}, FAILURE)
        carry_out(shrinking, partial(within, least, most), space(ranged("load")))
        assert shrinking.values == {"load": text}


def space(*axes: Axis) -> Space:
    return Space(axes)


def test_constraints_refuse_values_without_a_run() -> None:
    def allows(values: Mapping[str, str]) -> bool:
        return float(values["low"]) <= float(values["high"])

    some = Space((ranged("low"), ranged("high")), {"low": "0.5"}, allows)
    shrinking = Shrinking(1, {"low": "0.6", "high": "0.93"}, FAILURE)
    carry_out(shrinking, lambda values: float(values["high"]) > 0.2, some)  # checks that each point is allowed
    assert shrinking.values == {"low": "0.5", "high": "0.5"}


def test_all_repeats_but_a_minority_must_fail() -> None:
    fails, values = planted(0)
    shrinking = Shrinking(1, values, FAILURE)
    batches = shrinking.batches(SPACE, 1)
    point = next(batches)[0]
    row = told(point, fails).rows[0]
    with pytest.raises(StopIteration):
        batches.send([Told(point, (row, replace(row, status=End.PASSED), replace(row, where="main.osc:1:1")))])
    assert shrinking.outcome is Outcome.GONE and shrinking.repeated is not None
    assert FAILURE.holds(Told(point, (row, row, replace(row, status=End.ERROR))))
    assert not FAILURE.holds(Told(point, ()))
    assert SameFailure("", "", any_failure=True).matches(row)
    assert not SameFailure("", "", any_failure=True).matches(Row(1, "", 1, 1, 1, End.ERROR))


def test_points_are_repeated_where_runs_may_end_differently(tmp_path: Path) -> None:
    lab = tmp_path / "lab.yaml"
    lab.write_text("simulators: {hall: {simulator: mujoco}}\nrobots: {robot: {in: hall, as: turtlebot4}}\n")
    exact = (Options(clock="virtual"), Options(simulator=Simulator("mujoco")), Options(lab=Lab(lab)))
    assert [repeats_for(options, None) for options in exact] == [1, 1, 1]
    real = (Options(), Options(clock="real"), Options(ros=Ros("tcp/a:1"), simulator=Simulator("ros")))
    assert [repeats_for(options, None) for options in real] == [3, 3, 3]
    assert repeats_for(Options(), 2) == 2


def test_the_simplest_value_is_the_default_or_the_nearest_to_zero() -> None:
    assert simplest_of(ranged("a", -1, 2), "0.5") == "0.5"
    assert simplest_of(ranged("a", -1, 2), None) == "0.0"
    assert simplest_of(ranged("a", -3, -2), None) == "-2.0"
    assert simplest_of(Choices("a", ("5", "-2", "3"), (5.0, -2.0, 3.0), SPAN), None) == "-2"
    assert simplest_of(Choices("a", ("true", "false"), None, SPAN), None) == "false"
    assert simplest_of(Choices("a", ('"b"', '"a"'), None, SPAN), None) == '"b"'


def test_ladders_lead_from_the_simplest_value() -> None:
    def texts(ladder: Ladder) -> list[str]:
        return [ladder.at(rank) for rank in range(ladder.top + 1)]

    assert texts(ladder_of(ranged("a", 0, 9, is_whole=True), "2", "5")) == ["2", "3", "4", "5"]
    assert texts(ladder_of(ranged("a", 0, 9, is_whole=True), "5", "2")) == ["5", "4", "3", "2"]
    assert texts(ladder_of(ranged("a"), "0.0", "0.025")) == ["0.0", "0.01", "0.02", "0.025"]
    assert texts(ladder_of(ranged("a", -1, 0), "-0.005", "-0.03")) == ["-0.005", "-0.01", "-0.02", "-0.03"]
    assert texts(ladder_of(listed("a", 6), "1", "4")) == ["1", "2", "3", "4"]
    names = Choices("a", ("a", "b", "c", "d"), None, SPAN)
    assert texts(ladder_of(names, "b", "d")) == ["b", "a", "c", "d"]
    assert [step_of(ranged("a", 0, high)) for high in (0.4, 0.5, 3, 5)] == pytest.approx([0.001, 0.01, 0.01, 0.1])


ROW = Row(3, "", 3, 1, 7, End.FAILED)

TEXT = """import osc.types
import osc.helpers

scenario helper:
    do log("x")

# It fails for large loads.
scenario main:
    pause: time with:
        keep(it in [1s, 2s, 4s])
    load: float
    keep(load in [0.0..1.0])
    keep(default load == 0.1)
    slope: float
    keep(slope in [-0.5..0.5])
    keep(load < 0.9)
    limit: float
    name: string
    do serial:
        log(name)
        wait elapsed(pause)
        compare(load + slope, "<", limit)
"""
ONCE = """from pathlib import Path

from seoro import ActionContext, ActionFailed, action


@action("once")
async def once(ctx: ActionContext) -> None:
    if Path("flaky").exists():
        Path("flaky").unlink()
        raise ActionFailed("flaky")
"""


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """Folder with a scenario."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    return tmp_path


def run(*arguments: str) -> int:
    command = ["campaign", "run", "main.osc", "--scenario", "main", "--clock", "virtual", "--seed", "2", "-j", "1"]
    return main([*command, "--set", "name='a'", *arguments])


def first_failed() -> str:
    return next(row["run"] for row in table("campaign/runs.csv") if row["status"] == "failed")


def test_a_failed_run_becomes_a_scenario_file(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--set", "limit=0.8", "--strategy", "random", "--runs", "20") == 1
    number = next(row["run"] for row in table("campaign/runs.csv") if row["status"] == "failed")
    command = ["campaign", "shrink", "campaign", number, "-j", "1"]
    assert main([*command, "--runs", "6"]) == 0
    assert "stopped early: there may be simpler values" in capsys.readouterr().out
    assert main(command) == 0
    out = capsys.readouterr().out
    assert "stopped early" not in out and "the run itself" not in out, "it goes on"
    assert f"seoro exec main_{number}.osc --scenario main --clock virtual\n  it fails the same way" in out
    lines = Path(f"main_{number}.osc").read_text().splitlines()
    values = dict(
        line.removeprefix("# seoro: set ").split("=") for line in lines if line.startswith("# seoro: set")
    )
    assert float(values["load"]) + float(values["slope"]) == pytest.approx(0.8, abs=0.011)
    assert (values["pause"], values["limit"], values["name"]) == ("1s", "0.8", "'a'")
    folder = f"campaign/shrink/{int(number):06}"
    rows = table(f"{folder}/runs.csv")
    assert {row["parent"] for row in rows} == {number} and len({row["seed"] for row in rows}) == 1
    shrunk = asyncio.run(sc.shrink("campaign", int(number), jobs=1, file="again.osc"))
    assert (shrunk.outcome, shrunk.best) == ("minimal", int(rows[shrunk.best - 1]["run"]))
    assert shrunk.values == {path: values[path] for path in shrunk.values} and not shrunk.matters("pause")
    assert Path("again.osc").is_file() and len(table(f"{folder}/runs.csv")) == len(rows), "without more runs"
    report = write_report(Path("campaign")).read_text()
    assert f"Run {number}, shrunk" in report and f"<td>{shrunk.values['load']}</td><td>yes</td>" in report
    assert main(["campaign", "resume", folder]) == 2
    assert "`seoro campaign shrink` continues it" in capsys.readouterr().err


def test_values_that_a_run_has_drawn_come_from_its_trace(tmp_path: Path) -> None:
    generate(tmp_path, 0)
    letters = Choices("d", ('"x"', '"y"'), None, SPAN)
    some = space(ranged("a"), ranged("it.b", is_whole=True), listed("c", 3), letters, ranged("e"), ranged("f"))
    found = FoundRun(
        tmp_path, read_campaign(tmp_path), Planned(3, 3, 1, 7, {"a": "0.5"}, "grid"), replace(ROW, folder="kept/3")
    )
    assert values_of_run(found, some) == {"a": "0.5"}
    parameters = {"a": 0.7, "it": {"b": 1}, "c": 2.0, "d": "y", "e": "text"}
    (tmp_path / "kept" / "3").mkdir(parents=True)
    (tmp_path / "kept" / "3" / "trace.jsonl").write_text(json.dumps({"parameters": parameters}) + "\n")
    assert values_of_run(found, some) == {"a": "0.5", "it.b": "1", "c": "2", "d": '"y"'}


def test_a_failure_that_does_not_repeat_is_flaky(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("seoro.libraries").mkdir()
    Path("seoro.libraries/once.osc").write_text("action once\n")
    Path("seoro.libraries/once.py").write_text(ONCE)
    Path("main.osc").write_text("import osc.once\n" + TEXT.replace("log(name)", "once()"))
    Path("flaky").touch()
    assert run("--set", "limit=0.8", "--set", "load=0.1", "--set", "slope=0.0") == 1
    assert main(["campaign", "shrink", "campaign", "1", "-j", "1"]) == 1
    assert "run 1 is flaky: it failed, and with the same values and seed it is passed" in capsys.readouterr().out
    assert not Path("main_1.osc").exists()


def test_invalid_requests_are_refused(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("other.osc").write_text("")
    run("--vary", "limit in [0.9, -0.9]", "--set", "load=0.1", "--set", "slope=0.0", "--set", "pause=1s")
    for arguments, message in (
        (["1"], "run 1 of campaign passed; expected a failed run"),
        (["7"], "unknown run `7`"),
        (["2", "-o", "main.osc"], "main.osc is a file of the scenario"),
        (["2", "-o", "other.osc"], "other.osc exists, and was not written by seoro campaign"),
        (["2", "-o", "small"], "expected a scenario file for `-o`, found small"),
        (["2", "-o", "other.osc/one.osc"], "cannot write other.osc"),
    ):
        assert main(["campaign", "shrink", "campaign", *arguments]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.more
def test_a_failure_in_a_simulator_repeats_and_shrinks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("worlds").mkdir()
    Path("tests").mkdir()
    world = "name: plain\nrobots:\n  - {robot: turtlebot4, name: robot}\nextent: [-2.0, -2.0, 2.0, 2.0]\n"
    Path("worlds/plain.yaml").write_text(world)
    Path("tests/drive.osc").write_text("""import osc.driving
import osc.helpers
scenario main:
    robot: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps..0.3mps])
    keep(default pace == 0.15mps)
    limit: speed
    turn: bool
    keep(turn in [true, false])
    do serial:
        robot.drive(linear: pace, duration: 0.4s)
        compare(pace, "<", limit)
""")
    command = [
        "campaign",
        "run",
        "tests/drive.osc",
        "--strategy",
        "random",
        "--runs",
        "3",
        "--seed",
        "3",
        "-j",
        "1",
    ]
    options = ["--sim", "mujoco", "--world", "worlds/plain.yaml", "--rate", "max", "--set", "limit=0.2mps"]
    assert main([*command, *options, "-j", "1"]) == 1
    number = next(row["run"] for row in table("campaign/runs.csv") if row["status"] == "failed")
    assert main(["campaign", "replay", "campaign", number]) == 0
    assert f"equal: the trace is that of run {number} to the bit" in capsys.readouterr().out
    assert main(["campaign", "shrink", "campaign", number, "-j", "1", "-o", "small/one.osc"]) == 0
    assert "seoro exec small/one.osc --rate max\n  it fails the same way" in capsys.readouterr().out
    text = Path("small/one.osc").read_text()
    assert "# seoro: world ../worlds/plain.yaml\n" in text and "# seoro: set pace=0.2mps\n" in text
    assert main(["exec", "small/one.osc", "--sim", "mujoco", "--rate", "max"]) == 1
