"""Files of runs that a campaign keeps, and its list of runs without a run."""

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

from seoro.bridges.wire.outputs import EntityMeasurements, Measurements, RobotMeasurements
from seoro.campaign.work.measurements import of_item, of_robots
from seoro.cli.main import main
from tests.campaign.test_campaigns import TEXT, VIRTUAL, table

Write = Callable[[str], str]

INVOKED = """import osc.types
import osc.helpers

scenario main:
    do serial:
        log() with:
            keep(it.msg in ["a", "b"])
        second: log() with:
            keep(it.msg in ["c", "d"])
"""
DRIVING = """import osc.driving
scenario main:
    turtlebot4: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps, 0.2mps])
    do turtlebot4.drive(linear: pace, duration: 0.4s)
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def write_file(text: str) -> str:
        Path("main.osc").write_text(text)
        return "main.osc"

    return write_file


def first_records(kept: str) -> list[dict[str, object]]:
    """Return the records of a kept run."""
    return [json.loads(line) for line in Path("out", kept, "trace.jsonl").read_text().splitlines()]


def test_all_runs_keep_their_traces_on_request(write: Write) -> None:
    assert main(["campaign", "run", write(INVOKED), "--keep", "all", *VIRTUAL]) == 0
    rows = table()
    assert len(rows) == 4
    for row in rows:
        logs = [each["message"] for each in first_records(row["folder"]) if each["kind"] == "log"]
        assert logs == [row["log.msg"], row["second.msg"]]


def test_runs_are_listed_without_a_run(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["campaign", "run", write(TEXT.format(pause="1h")), "--seed", "5", "--list"]
    assert main(command) == 0
    assert capsys.readouterr().out.splitlines() == [
        "  noise in [0.0, 0.2]",
        "  way in [1m, 2m]",
        "  shift in [0.0..1.0]",
        "",
        "1  noise=0.0 way=1m  seed 5",
        "2  noise=0.0 way=2m  seed 5",
        "3  noise=0.2 way=1m  seed 5",
    ]
    assert main([*command, "--runs", "3", "--repeat", "2"]) == 0
    assert capsys.readouterr().out.splitlines()[4:] == [
        "1  noise=0.0 way=1m  seed 5", "2  noise=0.0 way=1m  seed 6", "3  noise=0.0 way=2m  seed 5"
    ]  # fmt: skip
    assert not Path("campaign").exists()


def test_a_list_says_that_nothing_varies(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = "import osc.helpers\nscenario main:\n    do log('x')\n"
    assert main(["campaign", "run", write(text), "--seed", "5", "--repeat", "2", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("  nothing varies; `--vary") and lines[1] == ""
    assert lines[2:] == ["1  without variation  seed 5", "2  without variation  seed 6"]


@pytest.mark.parametrize("strategy", ["grid", "random"])
def test_the_listed_runs_are_those_of_the_campaign(
    write: Write, capsys: pytest.CaptureFixture[str], strategy: str
) -> None:
    command = ["campaign", "run", write(TEXT.format(pause="0s")), "--strategy", strategy, "--runs", "3", *VIRTUAL]
    assert main([*command, "--list"]) == 0
    listed = [line.split() for line in capsys.readouterr().out.splitlines()[4:]]
    main(command)
    assert [(line[0], line[-1]) for line in listed] == [(row["run"], row["seed"]) for row in table()]
    assert len(listed) == 3


def test_a_long_list_is_cut(
    write: Write, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.cli.campaign_listing.MOST", 200)
    many = "".join(f"    p{number}: int\n    keep(p{number} in [0..9])\n" for number in range(6))
    text = f"import osc.helpers\nscenario main:\n{many}    do log('x')\n"
    assert main(["campaign", "run", write(text), "--levels", "10", "--seed", "1", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2] == "100  p0=0 p1=0 p2=0 p3=0 p4=9 p5=9  seed 1"
    assert lines[-1].endswith("and more; `--runs N` lists the first N")
    assert main(["campaign", "run", "main.osc", "--levels", "10", "--emit", "variants"]) == 2
    assert "more than 200 files would be written" in capsys.readouterr().err


def test_runs_are_written_as_scenario_files(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["campaign", "run", write(TEXT.format(pause="1h")), "--clock", "virtual", "--seed", "5"]
    assert main([*command, "--emit", "variants"]) == 0
    assert "run one with `seoro exec variants/main_1.osc --clock virtual`" in capsys.readouterr().out
    assert sorted(path.name for path in Path("variants").iterdir()) == ["main_1.osc", "main_2.osc", "main_3.osc"]
    assert main(["exec", "variants/main_3.osc", "--dry-run"]) == 0
    printed = capsys.readouterr().out
    assert "noise = 0.2" in printed and "seed 5" in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "shift=2.0"], "exclude all of the first 4 runs"),
        (["--set", "noise=0.0", "--set", "way=1m"], "the strategy `grid` has no values"),
    ],
)
def test_a_list_without_runs_is_refused(
    write: Write, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["campaign", "run", write(TEXT.format(pause="1h")), "--list", *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err and not printed.out


def test_robots_that_are_selected_do_not_vary(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    Path("lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco}\n")
    actor = "scenario main:\n    robot: differential_drive_robot"
    write("import osc.driving\n" + TEXT.format(pause="1h").replace("scenario main:", actor))
    lab = ["--lab", "lab.yaml", "--set", "robot=any:cart", "--set", "shift=0.5"]
    assert main(["campaign", "run", "main.osc", "--list", *lab]) == 0
    assert capsys.readouterr().out.splitlines()[:2] == ["  noise in [0.0, 0.2]", "  way in [1m, 2m]"]


def test_the_seeds_of_the_file_are_those_of_each_variant(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    write("# seoro: seed 4, 9\n\n" + TEXT.format(pause="0s"))
    command = ["campaign", "run", "main.osc", "--clock", "virtual", "-o", "out", "-j", "1", "--overwrite"]
    assert main([*command, "--set", "noise=0.0"]) == 0
    assert "seeds 4, 9" in capsys.readouterr().out
    shown = [(row["variant"], row["seed"]) for row in table()]
    assert shown == [("1", "4"), ("1", "9"), ("2", "4"), ("2", "9")]
    assert main([*command, "--set", "noise=0.0", "--seed", "3"]) == 0
    assert [row["seed"] for row in table()] == ["3", "3"]
    assert main([*command, "--set", "noise=0.0", "--strategy", "random", "--runs", "3"]) == 0
    assert [row["seed"] for row in table()] == ["4", "5", "6"]
    assert "draws a seed for each run, beginning with 4" in capsys.readouterr().err


@pytest.mark.more
def test_kept_runs_have_the_files_of_single_runs(write: Write) -> None:
    write(DRIVING)
    common = ["--sim", "mujoco", "--rate", "max", "--seed", "3", "--parquet"]
    assert main(["campaign", "run", "main.osc", *common, "--keep", "all", "-j", "1", "-o", "out"]) == 0
    assert main(["exec", "main.osc", *common, "--set", "pace=0.2mps", "-o", "alone"]) == 0
    kept, alone = Path("out", table()[1]["folder"]), Path("alone")
    for name in ("measurements.json", "trajectories.csv"):
        assert (kept / name).read_bytes() == (alone / name).read_bytes()
    assert (kept / "top_down.png").is_file()
    assert (kept / "trajectories.parquet").is_file() == (find_spec("pyarrow") is not None)
    without_walls = [
        [{**json.loads(line), "wall": None} for line in (folder / "trace.jsonl").read_text().splitlines()]
        for folder in (kept, alone)
    ]
    assert without_walls[0] == without_walls[1]


def test_measurements_and_samples_become_columns() -> None:
    robot = RobotMeasurements(
        path_length=1.5, driving_time=0.0, localisation_error=None, localisation_error_driving=None,
        localisation_error_max=None, localisation_deviation=None, closest_approach=None, contacts=0,
        goals_reached=0, goals_aborted=0, goals_canceled=0, recoveries=0,
    )  # fmt: skip
    box = EntityMeasurements(
        path_length=0.0, max_speed=0.0, contacts=1, contacts_with={"turtlebot4": 1}, time_in={}
    )
    measured = Measurements(
        world="maze", engine="mujoco", engine_version="3", seed=1, time=2.0, robots={"turtlebot4": robot},
        entities={"box": box},
    )  # fmt: skip
    found = dict(of_robots(measured))
    assert found["turtlebot4.path_length"] == 1.5 and found["turtlebot4.localisation_error"] is None
    assert found["box.contacts"] == 1 and found["box.contacts_with.turtlebot4"] == 1
    assert dict(of_item({"kind": "record", "item": "way", "value": 2.0})) == {"record.way": 2.0}
    both = {"kind": "cover", "item": "both", "value": {"way": 2.0, "side": "left"}}
    assert dict(of_item(both)) == {"cover.both.way": 2.0, "cover.both.side": "left"}
