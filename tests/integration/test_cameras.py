"""Cameras of scenarios, and their saved images."""

from pathlib import Path

import pytest

import seoro
from tests.integration.conftest import SCENARIOS, read_trace
from tests.sim_nodes.engines import MUJOCO_FIRST, needs_pictures

SNAPSHOTS = SCENARIOS / "cameras" / "snapshots.osc"
HEADER = "import osc.cameras\nimport osc.helpers\n\n"


def run(file: Path, folder: Path, *simulator: str) -> tuple[int, list[dict[str, object]]]:
    from seoro.cli.main import main

    arguments = ["exec", str(file), *simulator, "--world", "empty", "--rate", "max", "--seed", "0"]
    status = main([*arguments, "-o", str(folder)])
    return status, read_trace(folder / "trace.jsonl")


@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_snapshots_are_in_the_output_folder(
    engine: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    needs_pictures(engine)
    status, _ = run(SNAPSHOTS, tmp_path, "--sim", engine)
    assert status == 0
    out = capsys.readouterr().out
    pictures = {name: (tmp_path / f"{name}.png").read_bytes() for name in ("before", "after", "turtlebot4_front")}
    for name, data in pictures.items():
        assert data.startswith(b"\x89PNG")
        assert str(tmp_path / f"{name}.png") in out
    assert pictures["before"] != pictures["after"]


def test_impossible_camera_actions_fail_with_a_reason(tmp_path: Path, mujoco_node: str) -> None:
    needs_pictures("mujoco")
    file = tmp_path / "wrong.osc"
    file.write_text(
        HEADER
        + "scenario wrong:\n"
        + "    eye: camera\n"
        + "    other: camera with:\n        keep(it.source == 'turtlebot4/back')\n"
        + "    do serial:\n"
        + "        a: eye.take_snapshot() with:\n            inverter()\n"
        + "        b: eye.look_at(position_3d(x: 1m)) with:\n            inverter()\n"
        + "        c: other.place(pose_3d()) with:\n            inverter()\n"
        + "        eye.place(pose_3d(position_3d(z: 2m)))\n"
        + "        d: eye.take_snapshot('../up') with:\n            inverter()\n"
        + "        e: eye.take_snapshot('top_down') with:\n            inverter()\n"
        + "        f: eye.follow('ghost') with:\n            inverter()\n"
        + "        eye.take_snapshot('twice')\n"
        + "        eye.take_snapshot('twice')\n"
    )
    status, records = run(file, tmp_path, "--connect", mujoco_node)
    assert status == 0
    reasons = [str(r["reason"]) for r in records if r["kind"] == "attempt.end"]
    wanted = (
        "spawn it with `eye.place`",
        "unknown camera 'eye'",
        "unknown camera 'turtlebot4/back' (cameras: turtlebot4/front)",
        "invalid output file name '../up.png'",
        "invalid output file name 'top_down.png'",
        "unknown entity 'ghost'",
    )
    for words in wanted:
        assert any(words in reason for reason in reasons), (words, reasons)
    assert (tmp_path / "twice.png").read_bytes() == (tmp_path / "twice_2.png").read_bytes()


@pytest.mark.more
async def test_images_are_not_kept_without_an_output_folder() -> None:
    needs_pictures("mujoco")
    simulator = seoro.Simulator(name="mujoco", world="empty")
    async with seoro.start(seoro.load(SNAPSHOTS), seed=0, simulator=simulator, keep_trace=True) as started:
        verdict = await started.result()
        logs = [record["message"] async for record in started.trace() if record["kind"] == "log"]
    assert verdict.passed
    assert started.files == ()
    assert any("(640 by 480 pixels); not saved" in message for message in logs), logs
