"""Time until a ROS 2 robot is commanded to stop when its run or its bridge dies or hangs.

    python benchmarks/robot_stops.py

A made-up robot, the bridge, a router and the run are processes of their own on this machine. Each time is from the
signal that the run or the bridge gets to what the robot notes: zero velocity, or a goal of its navigation that was
canceled.
"""

from __future__ import annotations

import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.bridges.ros2.robots.test_safety import DRIVER, drives, goal_ended, has_goal, wait_for
from tests.routers import free_endpoint, process, router_process

REPEATS = 12
Moment = Callable[[], float | None]
TWIST = "geometry_msgs/msg/Twist"


@contextmanager
def bridged(folder: Path, router: str) -> Iterator[tuple[Bridged, subprocess.Popen[bytes]]]:
    """A bridge to the robot, in a process of its own."""
    endpoint = f"unixsock-stream/{folder}/{time.monotonic_ns()}"
    with process("-c", BRIDGE, router, endpoint, "tb") as bridge:
        yield Bridged(endpoint, folder / "tb"), bridge


def measured(folder: Path, router: str, number: signal.Signals, whom: str, how: str) -> float:
    """The time [s] of one run that drives by commands of velocity, or by a goal."""
    with bridged(folder, router) as (robot, bridge), process(DRIVER, robot.endpoint, "tb", how) as driver:
        begun: Moment = partial(drives if how == "velocity" else has_goal, robot)
        ended: Moment = robot.stopped if how == "velocity" else partial(goal_ended, robot)
        wait_for(time.monotonic(), begun)
        time.sleep(0.1)
        moment = time.monotonic()
        (driver if whom == "run" else bridge).send_signal(number)
        taken = wait_for(moment, ended)
    time.sleep(0.6)  # until zero is not repeated any more
    return taken


def main() -> None:
    """Measure, and print a row for each case."""
    router = free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with router_process(router), process(str(FAKE_ROBOT), name, router, "tb", TWIST):
            for whom, number, how in product(
                ("run", "bridge"), (signal.SIGKILL, signal.SIGSTOP), ("velocity", "goal")
            ):
                times = [measured(folder, router, number, whom, how) * 1e3 for _ in range(REPEATS)]
                print(
                    f"{whom:6} {number.name:8} {how:9} median {statistics.median(times):4.0f} ms, "
                    f"longest {max(times):4.0f} ms",
                    flush=True,
                )


if __name__ == "__main__":
    main()
