"""One scenario, three labs: both robots simulated, both behind the bridge to ROS 2, and one of each.

The bridge serves the robots of a playing simulator, which another process exposes as a ROS 2 system. Between
its physics and the run lie two processes and a router.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import seoro
from seoro.runtime.verdict import RunStatus
from tests.routers import free_endpoint
from tests.sim_nodes.engines import make_engine

pytestmark = pytest.mark.slow

CROSSING = Path(__file__).parents[2] / "scenarios" / "multi_robot"
WRITTEN = "tcp/127.0.0.1:7460"  # where the lab files expect the bridge


@contextmanager
def command(*arguments: str) -> Iterator[None]:
    """Yield a command of seoro that has printed that it is ready."""
    with subprocess.Popen([sys.executable, "-m", "seoro", *arguments], stdout=subprocess.PIPE) as running:
        try:
            assert running.stdout is not None
            assert running.stdout.readline()
            yield
        finally:
            running.terminate()


@pytest.fixture
def bridge() -> Iterator[str]:
    """Yield the endpoint of a bridge to both robots of an exposed simulator."""
    make_engine("mujoco")
    simulator, ros, bridge = free_endpoint(), free_endpoint(), free_endpoint()
    robots = ("--robot", "turtlebot4:leader@/turtlebot4", "--robot", "turtlebot4:follower@/second")
    with ExitStack() as stack:
        for arguments in (
            ("sim", "mujoco", "--world", "hall", "--rate", "1", "--listen", simulator),
            ("bridge", "ros2", "--expose", "--simulator", simulator, "--ros-listen", ros),
            ("bridge", "ros2", *robots, "--ros", ros, "--listen", bridge),
        ):
            stack.enter_context(command(*arguments))
        yield bridge


def crossing(lab: Path, rate: float | None = None) -> None:
    verdict = seoro.run(seoro.load(CROSSING / "crossing.osc"), lab=seoro.Lab(lab, rate), seed=3)
    assert verdict.status is RunStatus.PASSED, verdict.reason


def test_the_crossing_passes_with_both_robots_in_a_simulator() -> None:
    make_engine("mujoco")
    crossing(CROSSING / "labs" / "simulated.yaml", math.inf)


@pytest.mark.parametrize("name", ["bridged", "mixed"])
def test_the_crossing_passes_with_robots_behind_the_bridge_to_ros_2(
    bridge: str, name: str, tmp_path: Path
) -> None:
    lab = tmp_path / "lab.yaml"
    lab.write_text((CROSSING / "labs" / f"{name}.yaml").read_text().replace(WRITTEN, bridge))
    crossing(lab)
