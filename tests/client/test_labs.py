"""Several executors, simulators and bridges that form one lab, behind one router."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.cli.main import main
from tests.bridges.robot.conftest import Rails, rails_at
from tests.executors import HELLO, RunningExecutor, executor
from tests.routers import process, routing

DEADLINE = 60.0  # [s]
TWO_ROBOTS = """import osc.helpers
import osc.driving
import osc.nav2
scenario both:
    timeout(20s)
    leader: differential_drive_robot
    follower: differential_drive_robot
    do parallel:
        leader.drive(linear: 0.3mps, duration: 1s)
        serial:
            follower.init_nav2(pose_3d())
            follower.nav_to_pose(pose_3d(position: position_3d(x: 0.2m)))
"""
LAB = """simulators:
  hall: {{connect: {router}, name: {simulator}, world: hall}}
bridges:
  floor: {{connect: {router}, name: rails}}
robots:
  leader: {{in: hall, as: turtlebot4}}
  follower: {{in: floor, as: line}}
"""


@pytest.fixture(scope="module")
def router() -> Iterator[str]:
    with routing() as endpoint:
        yield endpoint


@pytest.fixture
def two(router: str, tmp_path: Path) -> Iterator[tuple[RunningExecutor, RunningExecutor]]:
    """Yield two executors at one router."""
    with ExitStack() as stack:
        made = []
        for name in ("lab-a", "lab-b"):
            folder = tmp_path / name
            folder.mkdir()
            made.append(stack.enter_context(executor(folder, name=name, connect=router)))
        yield made[0], made[1]


async def test_executors_at_one_router_form_a_lab(
    router: str, two: tuple[RunningExecutor, RunningExecutor], tmp_path: Path
) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    async with seoro.Client(router) as client:
        assert await client.executors() == ["lab-a", "lab-b"]
        runs = [await client.submit(name, file) for name in ("lab-b", "lab-a")]
        with anyio.fail_after(DEADLINE):
            for run in runs:
                assert (await run.result()).passed
        listed = {run.id: run.executor.name for run in await client.runs()}
        assert listed == {runs[0].id: "lab-b", runs[1].id: "lab-a"}
        assert [run.id for run in await client.runs("lab-b")] == [runs[0].id]
        assert [status.name for status in await client.describe()] == ["lab-a", "lab-b"]


@pytest.mark.more
def test_a_second_executor_with_a_name_in_use_is_refused(
    router: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = tmp_path / "first"
    first.mkdir()
    second = ["serve", "--name", "lab-a", "--connect", router, "--folder", str(tmp_path / "second")]
    with executor(first, connect=router) as lab:
        assert main(second) == 2
        assert "duplicate executor 'lab-a'" in capsys.readouterr().err
        lab.kill()
        with executor(first, connect=router):  # a killed client does not hinder others
            pass


@pytest.fixture(scope="module")
def nodes(router: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rails]:
    """Start two simulators and a bridge at one router; return the bridge."""
    with ExitStack() as stack:
        for name in ("sim-a", "sim-b"):
            command = ("-m", "sim_nodes", "mujoco", "--connect", router, "--node", name, "--world", "hall")
            stack.enter_context(process(*command, says=None))
        yield stack.enter_context(rails_at(tmp_path_factory.mktemp("rails"), "--connect", router, "line"))


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_a_scenario_uses_robots_of_different_machines(
    router: str, two: tuple[RunningExecutor, RunningExecutor], nodes: Rails, tmp_path: Path
) -> None:
    file = tmp_path / "both.osc"
    file.write_text(TWO_ROBOTS)
    before = len(nodes.commands())
    async with seoro.Client(router) as client:
        with anyio.fail_after(DEADLINE):
            for name, simulator in (("lab-a", "sim-b"), ("lab-b", "sim-a")):
                lab = tmp_path / f"{name}.yaml"
                lab.write_text(LAB.format(router=router, simulator=simulator))
                verdict = await (await client.submit(name, file, lab=seoro.Lab(lab))).result()
                assert verdict.passed, verdict.reason
    assert len(nodes.commands()) > before


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_an_ambiguous_simulator_is_refused(
    router: str, nodes: Rails, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, lab = tmp_path / "both.osc", tmp_path / "lab.yaml"
    file.write_text(TWO_ROBOTS)
    lab.write_text(LAB.format(router=router, simulator="sim-c"))
    assert main(["exec", str(file), "--lab", str(lab)]) == 3
    err = capsys.readouterr().err
    assert "no simulator node 'sim-c' found" in err
    lab.write_text(LAB.format(router=router, simulator="sim-c").replace("name: sim-c, ", ""))
    assert main(["exec", str(file), "--lab", str(lab)]) == 2
    assert "several nodes at" in capsys.readouterr().err
