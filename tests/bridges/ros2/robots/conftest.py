"""A ROS 2 robot and a bridge to it, each in its own process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

import seoro
from seoro.runtime.verdict import Verdict
from tests.routers import free_endpoint, process, router_process

FAKE_ROBOT = Path(__file__).with_name("fake_robot.py")
BRIDGE = """
import sys
import anyio
from seoro.bridges.ros2.participant import RosOptions
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import BridgeOptions, bridging

async def main():
    ros, listen, *robots = sys.argv[1:]
    profile = read_profile("turtlebot4")
    bridged = [BridgedRobot(name, profile, f"/{name}") for name in robots]
    async with bridging(BridgeOptions(bridged, RosOptions(ros), listen=listen)):
        print("ready", flush=True)
        await anyio.sleep_forever()

anyio.run(main)
"""


@dataclass(frozen=True)
class Bridged:
    """A robot behind a bridge: endpoint of the bridge, and file with the notes of the robot."""

    endpoint: str
    log: Path
    name: str = "tb"
    since: float = field(default_factory=time.monotonic)

    def notes(self, what: str) -> list[tuple[float, float]]:
        """Return the notes of a kind since the test began, as pairs of time [s, machine clock] and value."""
        lines = [line.split() for line in self.log.read_text().splitlines()]
        noted = [(float(when), float(value)) for when, kind, value in lines if kind == what]
        return [(when, value) for when, value in noted if when >= self.since]

    def begun(self) -> Bridged:
        """Return a copy that ignores earlier notes."""
        return replace(self, since=time.monotonic())

    def stopped(self) -> float | None:
        """Return the time of the zero after the last velocity [s, machine clock]; None while the robot drives."""
        velocities = self.notes("velocity")
        motions = [index for index, (_, value) in enumerate(velocities) if value]
        if not motions or len(velocities) == motions[-1] + 1:
            return None
        return velocities[motions[-1] + 1][0]


async def run_on_robot(folder: Path, text: str, endpoint: str, actor: str, robot: str) -> Verdict:
    """Run a scenario with a robot behind a bridge as an actor."""
    (folder / "main.osc").write_text(text)
    lab = folder / "lab.yaml"
    lab.write_text(f"bridges:\n  b: {{connect: {endpoint}}}\nrobots:\n  {actor}: {{in: b, as: {robot}}}\n")
    async with seoro.start(seoro.load(folder / "main.osc"), lab=seoro.Lab(lab)) as run:
        return await run.result()


@pytest.fixture(scope="package")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Yield two robots `tb` and `stamped` behind a bridge; the second needs stamped velocities."""
    folder = tmp_path_factory.mktemp("bridged")
    router = free_endpoint()
    fake = [str(FAKE_ROBOT), str(folder), router]
    with (
        router_process(router),
        process(*fake, "tb", "geometry_msgs/msg/Twist"),
        process(*fake, "stamped", "geometry_msgs/msg/TwistStamped"),
        process("-c", BRIDGE, router, f"unixsock-stream/{folder}/bridge", "tb", "stamped"),
    ):
        yield folder


@pytest.fixture(params=["tb"])
def bridged(request: pytest.FixtureRequest, running: Path) -> Bridged:
    """Return a robot behind a bridge."""
    return Bridged(f"unixsock-stream/{running}/bridge", running / request.param, request.param)
