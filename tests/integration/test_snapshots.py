"""`osc.snapshots` and `--from-snapshot`, on simulator nodes."""

import shutil
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.snapshots import read_snapshot
from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SAVE = """
import osc.helpers
import osc.ros
import osc.gazebo
import osc.snapshots

scenario main:
    robot: differential_drive_robot
    box: sim_object
    do serial:
        robot.init_nav2(pose_3d())
        parallel:
            robot.nav_to_pose(pose_3d(position_3d(x: 1.5m, y: 1.5m)))
            serial:
                robot.odometry_distance_traveled(0.5m)
                save_snapshot('on_the_way')
                box.spawn(pose_3d(position_3d(x: 4m, y: 4m, z: 0.1m)), 'example_simulation://models/box.sdf')
                actor_exists('box')
        restore_snapshot('on_the_way')
        actor_exists('box') with:
            inverter()
        log('back')
"""

REST = """
import osc.nav2
import osc.helpers
import osc.snapshots

scenario main:
    robot: differential_drive_robot
    do serial:
        robot.nav_to_pose(pose_3d(position_3d(x: 1.5m, y: 1.5m)))
"""


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that has saved a snapshot."""
    folder = tmp_path_factory.mktemp("saved")
    (folder / "save.osc").write_text(SAVE)
    (folder / "rest.osc").write_text(REST)
    options = ["--sim", "mujoco", "--rate", "max", "--seed", "7", "-o", str(folder / "out")]
    assert main(["exec", str(folder / "save.osc"), *options]) == 0
    return folder


def ends(trace: Path) -> dict[str, float]:
    """Return the end times of behaviors by name."""
    names = {r["id"]: r["name"] for r in read_trace(trace) if r["kind"] == "behavior.start"}
    return {names[r["id"]]: r["t"] for r in read_trace(trace) if r["kind"] == "behavior.end"}


def begin(folder: Path, *options: str, scenario: str = "rest.osc", snapshot: Path | None = None) -> int:
    given = str(snapshot or folder / "out" / "on_the_way.snapshot")
    return main(["exec", str(folder / scenario), "--from-snapshot", given, "--rate", "max", *options])


@pytest.mark.more
def test_a_run_from_a_snapshot_continues_the_saved_run(saved: Path, tmp_path: Path) -> None:
    before = ends(saved / "out" / "trace.jsonl")
    assert begin(saved, "--seed", "7", "-o", str(tmp_path)) == 0
    after = ends(tmp_path / "trace.jsonl")
    took = before["robot.nav_to_pose"] - before["save_snapshot"]
    assert after["robot.nav_to_pose"] == pytest.approx(took, abs=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--world", "maze"), "a world contradicts a snapshot"),
        (("--clock", "virtual"), "the clock 'virtual' is impossible with a simulator"),
    ],
)
def test_options_in_conflict_with_a_snapshot_are_refused(
    saved: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str
) -> None:
    assert begin(saved, *options) == 2
    assert words in capsys.readouterr().err


def test_files_without_a_snapshot_are_refused(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, words in (("save.osc", "invalid snapshot"), ("none", "cannot read the snapshot")):
        assert begin(saved, snapshot=saved / name) == 2
        assert words in capsys.readouterr().err


@pytest.mark.more
def test_a_snapshot_of_another_version_is_refused(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    snapshot = read_snapshot(saved / "out" / "on_the_way.snapshot")
    file = tmp_path / "old.snapshot"
    file.write_bytes(wire.encode(snapshot.model_copy(update={"engine_version": "1.0"})))
    assert begin(saved, snapshot=file) == 2
    message = capsys.readouterr().err
    assert "cannot begin from the snapshot: the snapshot requires the version of mujoco 1.0" in message
    assert "it was made by mujoco 1.0" in message


@pytest.mark.more
def test_failed_saves_and_restores_report_their_reason(
    saved: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    shutil.copy(saved / "rest.osc", tmp_path)
    for action, words in (
        ("restore_snapshot('never')", "unknown snapshot 'never' (saved in this run: none)"),
        ("save_snapshot('../outside')", "invalid name '../outside' of a snapshot"),
    ):
        (tmp_path / "wrong.osc").write_text(REST + f"        {action}\n")
        snapshot = saved / "out" / "on_the_way.snapshot"
        assert begin(tmp_path, scenario="wrong.osc", snapshot=snapshot) == 1
        assert words in capsys.readouterr().err


@pytest.mark.more
def test_a_campaign_starts_each_run_from_the_snapshot(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rest.osc").write_text(REST.replace("1.5m, y", "x, y").replace("    do", AXIS + "    do"))
    options = ["--rate", "max", "--seed", "7", "-o", str(tmp_path / "results")]
    snapshot = saved / "out" / "on_the_way.snapshot"
    rest = ["campaign", "run", str(tmp_path / "rest.osc")]
    assert main([*rest, "--from-snapshot", str(snapshot), *options]) == 0
    rows = (tmp_path / "results" / "runs.csv").read_text().splitlines()
    assert len(rows) == 3
    assert main([*rest, "--from-snapshot", str(saved / "save.osc"), *options]) == 2
    assert "invalid snapshot" in capsys.readouterr().err


AXIS = """    x: length with:
        keep(it in [1.3m, 1.5m])
"""
