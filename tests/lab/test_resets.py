"""Reset scenarios of a lab after a run."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.client import Client
from seoro.embed import prepare
from seoro.embed.options import Options
from seoro.lab.commands import LabCommands
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.conftest import Rails
from tests.executors import NAME, executor
from tests.lab.test_runs import ALONE, lab_of, run
from tests.sim_nodes.engines import make_engine

DEADLINE = 40.0  # [s]
BACK = """import osc.helpers
import osc.robotics
import osc.driving

scenario back:
    base: differential_drive_robot
    do serial:
        base.drive(linear: -0.3mps, duration: 0.05s)
"""
FOR_LONG = BACK.replace("0.05s", "60s")


def robots(rails: Rails, after: str) -> str:
    return (
        f"bridges:\n  floor: {{connect: {rails.endpoint}}}\nrobots:\n"
        f"  leader: {{in: floor, as: line, after: {after}}}\n"
    )


def lab_with(folder: Path, rails: Rails, text: str, after: str = "{scenario: back.osc}") -> seoro.Lab:
    (folder / "back.osc").write_text(text)
    (folder / "go.osc").write_text(ALONE)
    return lab_of(folder, robots(rails, after))


def test_a_reset_runs_while_the_robot_is_held(rails: Rails, tmp_path: Path) -> None:
    lab = lab_with(tmp_path, rails, BACK)
    assert run(tmp_path, ALONE, lab).status is RunStatus.PASSED
    velocities = [velocity for _, _, velocity in rails.commands()]
    assert [velocity for velocity in velocities if velocity][-2:] == [0.5, -0.3]
    assert velocities[-1] == 0.0


def test_a_failed_reset_is_a_warning_with_its_position(
    rails: Rails, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    text = BACK + "        base.drive(linear: 0.3mps, duration: 60s)\n"
    lab = lab_with(tmp_path, rails, text, "{scenario: back.osc, within: 0.3}")
    assert run(tmp_path, ALONE, lab).status is RunStatus.PASSED
    assert "teardown of the robot 'leader' failed" in caplog.text
    assert "error: it takes longer than 0.3 s" in caplog.text
    assert rails.commands()[-1][2] == 0.0
    text = BACK.replace("import osc.driving", "import osc.nav2").partition("        base")[0]
    text += "        base.nav_to_pose(pose_3d(position: position_3d(x: 200m)))\n"
    assert run(tmp_path, ALONE, lab_with(tmp_path, rails, text)).status is RunStatus.PASSED
    assert "the rails end at 100 m" in caplog.text
    assert "back.osc:8:9" in caplog.text


ARM = BACK.partition("    base")[0] + "    base: osc_actor\n    do serial:\n        wait elapsed(1s)\n"
NO_ARM = r"lab\.yaml:4: 'line' of bridge 'rails' cannot stand for `base` of the type osc_actor"
TWO = BACK.replace("    do", "    other: differential_drive_robot\n    do")
NOT_ONE = r"lab\.yaml:4: the reset scenario back in .*back\.osc must have .* one actor, .*found base, other"


@pytest.mark.parametrize(
    ("text", "words"), [(BACK.replace("drive(", "fly("), r"back\.osc:8:14"), (ARM, NO_ARM), (TWO, NOT_ONE)]
)
def test_impossible_resets_are_refused_before_the_run(rails: Rails, tmp_path: Path, text: str, words: str) -> None:
    lab = lab_with(tmp_path, rails, text)
    before = len(rails.commands())
    with pytest.raises((seoro.UsageError, seoro.InvalidScenario), match=words):
        run(tmp_path, ALONE, lab)
    assert not any(velocity for _, _, velocity in rails.commands()[before:])


def test_a_missing_reset_scenario_is_reported_with_the_line_of_the_lab(rails: Rails, tmp_path: Path) -> None:
    lab = lab_with(tmp_path, rails, BACK, "{scenario: other.osc}")
    with pytest.raises(seoro.UsageError, match=r"lab\.yaml:4: robots\.leader\.after: file not found: .*other"):
        run(tmp_path, ALONE, lab)
    with pytest.raises(seoro.UsageError, match="and `scenario`"):
        run(tmp_path, ALONE, lab_with(tmp_path, rails, BACK, "{scenario: back.osc, home: {x: 0, y: 0}}"))


@pytest.mark.more
def test_a_reset_in_a_simulator_has_its_time_limit(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    make_engine("mujoco")
    text = "simulators:\n  sim: {simulator: mujoco, world: empty}\nrobots:\n"
    text += "  leader: {in: sim, as: turtlebot4, after: AFTER}\n"
    (tmp_path / "back.osc").write_text(BACK + "        wait elapsed(3.3s)\n")
    short = ALONE.partition("    do")[0] + "    do serial:\n        wait elapsed(0.5s)\n"
    lab = lab_of(tmp_path, text.replace("AFTER", "{scenario: back.osc, within: 3.4}"))
    assert run(tmp_path, short, lab).status is RunStatus.PASSED
    assert caplog.text == ""
    lab = lab_of(tmp_path, text.replace("AFTER", "{scenario: back.osc, within: 3.3}"))
    assert run(tmp_path, short, lab).status is RunStatus.PASSED
    assert "error: it takes longer than 3.3 s" in caplog.text


async def test_a_dry_run_runs_no_reset(rails: Rails, tmp_path: Path) -> None:
    lab = lab_with(tmp_path, rails, BACK)
    before = len(rails.commands())
    async with prepare(seoro.load(tmp_path / "go.osc"), Options(lab=lab)):
        pass
    assert not any(velocity for _, _, velocity in rails.commands()[before:])


async def driving_back(rails: Rails) -> None:
    with anyio.fail_after(DEADLINE):
        while rails.commands()[-1][2] != -0.3:
            await anyio.sleep(0.02)


@pytest.mark.parametrize("after", ["{scenario: back.osc}", "{home: {x: 90, y: 0}}"])
async def test_an_emergency_stop_ends_a_reset_at_once(
    rails: Rails, tmp_path: Path, caplog: pytest.LogCaptureFixture, after: str
) -> None:
    lab = lab_with(tmp_path, rails, FOR_LONG, after)
    scenario = seoro.load(tmp_path / "go.osc")
    try:
        with anyio.fail_after(DEADLINE):
            async with seoro.start(scenario, lab=lab) as started:
                assert (await started.result()).passed
                before = len(rails.commands())

                async def stop() -> None:
                    while not any(velocity for _, _, velocity in rails.commands()[before:]):
                        await asyncio.sleep(0.02)
                    await LabCommands([rails.endpoint]).emergency_stop_all("ana@lab", "smoke")

                stopping = asyncio.create_task(stop())
            await stopping
    finally:
        await LabCommands([rails.endpoint]).release_all("a test", "it is over")
    assert "no robot may move: emergency stop by ana@lab" in caplog.text
    assert rails.commands()[-1][2] == 0.0


async def test_stopping_a_finished_run_ends_its_reset(
    rails: Rails, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    lab = lab_with(tmp_path, rails, FOR_LONG)
    scenario = seoro.load(tmp_path / "go.osc")
    with anyio.fail_after(DEADLINE):
        async with anyio.create_task_group() as tasks, seoro.start(scenario, lab=lab) as started:
            assert (await started.result()).passed

            async def stop() -> None:
                await driving_back(rails)
                started.stop()

            tasks.start_soon(stop)
    assert "failed: cancelled" in caplog.text
    assert rails.commands()[-1][2] == 0.0


async def test_ctrl_c_ends_a_reset_at_once(rails: Rails, tmp_path: Path) -> None:
    lab = lab_with(tmp_path, rails, FOR_LONG)
    command = [sys.executable, "-m", "seoro", "exec", str(tmp_path / "go.osc"), "--lab", str(lab.file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        await driving_back(rails)
        running.send_signal(signal.SIGINT)
        out, err = await anyio.to_thread.run_sync(running.communicate, None, 20)
    assert running.returncode == 130
    assert "passed" in out
    assert "failed: cancelled" in err
    assert rails.commands()[-1][2] == 0.0


@pytest.mark.more
async def test_a_reset_runs_on_an_executor_and_ends_with_a_stop(rails: Rails, tmp_path: Path) -> None:
    folder = tmp_path / "labs"
    folder.mkdir()
    (tmp_path / "shared.osc").write_text("import osc.driving\n")
    text = FOR_LONG.replace("import osc.driving", 'import "../shared.osc"\nimport osc.driving')
    lab = lab_with(folder, rails, text)
    with executor(tmp_path) as there:
        async with Client(there.endpoint) as client:
            run = await client.submit(NAME, folder / "go.osc", lab=lab)
            await driving_back(rails)
            await run.stop("enough")
            with anyio.fail_after(DEADLINE):
                assert (await run.result()).passed
    assert rails.commands()[-1][2] == 0.0


@pytest.mark.more
async def test_an_emergency_stop_of_the_executor_skips_the_reset(rails: Rails, tmp_path: Path) -> None:
    lab = lab_with(tmp_path, rails, FOR_LONG)
    (tmp_path / "go.osc").write_text(ALONE.replace("0.2m", "50m"))
    with executor(tmp_path) as there:
        async with Client(there.endpoint) as client:
            run = await client.submit(NAME, tmp_path / "go.osc", lab=lab)
            with anyio.fail_after(DEADLINE):
                while rails.commands()[-1][2] != 0.5:
                    await anyio.sleep(0.02)
                await LabCommands([there.endpoint]).emergency_stop_all("ana@lab", "smoke")
                assert (await run.result()).status is RunStatus.CANCELLED
            await LabCommands([there.endpoint]).release_all("a test", "it is over")
    assert -0.3 not in [velocity for _, _, velocity in rails.commands()]
    assert rails.commands()[-1][2] == 0.0
