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
        ("--vary=lost.volume in [1.0..2.0]", "did you mean `last`?"),
        ("--vary=robot.volume in [1.0..2.0]", "the invocations are `greet` and `last`"),
        ("--vary=pace", "missing values for `pace`, which shall vary"),
        ("--vary=last.volume", "write `last.volume in [LOW..HIGH]`"),
        ("--vary=pace > 2mps", "`pace > 2mps` makes no parameter vary"),
        ("--vary=greet.volume in [1.0, 2.0]", "the scenario has an argument for it, `2.0`"),
        ("--vary=world?wall_height in [1, 2]", "`world?wall_height` needs the name or the file of a world"),
        ("--vary=world?wall_height in 1", "invalid values of a world"),
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


def test_values_that_an_invoked_scenario_refuses_are_excluded(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*COMMAND, "--vary", "last.volume in [4.0, 7.0]", "--constrain", "number == 1"]) == 0
    assert "1 passed, 1 excluded by constraints" in capsys.readouterr().out
    assert [row["last.volume"] for row in table()] == ["4.0"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--vary", "last.volume in [6.0, 7.0]", "--set", "number=1"], "constraints exclude all 2 runs"),
        (["--strategy", "pairwise", "--constrain", "number > 9"], "constraints exclude all values"),
    ],
)
def test_constraints_that_leave_no_run_are_refused(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    varied = ["--vary", "pace in [1mps, 2mps]"]
    assert main([*COMMAND, *(varied if "pairwise" in options else []), *options]) == 2
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


WORLD = """name: hall
extent: [-3, -3, 3, 3]
walls:
  - points: [[-2, -2], [2, -2]]
robots:
  - {name: turtlebot4, robot: turtlebot4}
"""
ROBOT = """import osc.ros
import osc.driving
import osc.faults
import osc.measures
import osc.worlds
import osc.helpers

scenario main:
    robot: differential_drive_robot with:
        keep(it.namespace == "turtlebot4")
    rooms: int
    keep(rooms in [2, 4])
    var path: length = 0m
    record(path, unit: m)
    do serial:
        load_world_with("office", counts: [count_setting("generate.rooms.count", rooms)])
        parallel:
            slip: robot.inject_wheel_slip()
            push: robot.drive(duration: 2s)
        store_measurement("turtlebot4", "path_length", path)
"""


@pytest.mark.more
def test_worlds_faults_and_actions_vary_in_a_simulator(capsys: pytest.CaptureFixture[str]) -> None:
    Path("main.osc").write_text(ROBOT)
    Path("hall.yaml").write_text(WORLD)
    varied = ("world?wall_height in [1, 2.5]", "slip.left in [0.2, 0.9]", "push.linear in [0.3mps]")
    options = [word for each in varied for word in ("--vary", each)]
    command = [
        "campaign",
        "run",
        "main.osc",
        "--sim",
        "mujoco",
        "--world",
        "hall.yaml",
        "--rate",
        "max",
        "-j",
        "1",
    ]
    command += ["--seed", "1", "--vary", "rooms in [2]"]
    assert main([*command, *options, "--keep", "all", "-o", "out"]) == 0
    rows = table()
    path = {row["slip.left"]: float(row["record.path"]) for row in rows}
    assert len(rows) == 4 and path["0.9"] < 0.9 * path["0.2"]
    assert {row["world?wall_height"] for row in rows} == {"1", "2.5"}
    assert main(["campaign", "replay", "out", "2"]) == 0


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        ("world?wall_hight in [1]", "unknown key `wall_hight` (did you mean `wall_height`?)"),
        ("world?generate.rooms.count in [3, lots]", "generate.rooms.count: Input should be a valid integer"),
        ("world?wall_height in [-1..2]", "wall_height: Input should be greater than 0"),
        ("world?robots.tb.pose in [start]", "unknown item `tb`; expected a name (turtlebot4)"),
    ],
)
def test_invalid_keys_and_values_of_worlds_are_one_early_error(
    varied: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["campaign", "run", "main.osc", "--sim", "mujoco", "--world", "office", "-o", "out"]
    assert main([*command, "--set", "number=1", "--levels", "2", "--vary", varied]) == 2
    assert message in capsys.readouterr().err
    assert not Path("out").exists(), "nothing has begun"
