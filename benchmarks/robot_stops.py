"""How long a robot of ROS 2 takes to be told to stop when the run that drives it dies or hangs.

    python benchmarks/robot_stops.py

A made-up robot, the bridge, a router and the run are processes of their own on this machine. Each time is from the
signal that the run gets to what the robot notes: zero velocity, or a goal of its navigation that was canceled.
"""

from __future__ import annotations

import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.bridges.ros2.robots.test_safety import DRIVER, drives, goal_ended, has_goal, wait_for
from tests.routers import free_endpoint, process, router_process

REPEATS = 12
Moment = Callable[[], float | None]
TWIST = "geometry_msgs/msg/Twist"


def measured(folder: Path, number: signal.Signals, how: str) -> float:
    """The time [s] of one run that drives by commands of velocity, or by a goal."""
    robot = Bridged(f"unixsock-stream/{folder}/bridge", folder / "tb")
    begun: Moment = partial(drives if how == "velocity" else has_goal, robot)
    ended: Moment = robot.stopped if how == "velocity" else partial(goal_ended, robot)
    with process(DRIVER, robot.endpoint, "tb", how) as driver:
        wait_for(time.monotonic(), begun)
        time.sleep(0.1)
        moment = time.monotonic()
        driver.send_signal(number)
        taken = wait_for(moment, ended)
    time.sleep(0.6)  # until zero is not repeated any more
    return taken


def main() -> None:
    """Measure, and print a row for each case."""
    router = free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with (
            router_process(router),
            process(str(FAKE_ROBOT), name, router, "tb", TWIST),
            process("-c", BRIDGE, router, f"unixsock-stream/{name}/bridge", "tb"),
        ):
            for number in (signal.SIGKILL, signal.SIGSTOP):
                for how in ("velocity", "goal"):
                    times = [measured(folder, number, how) * 1e3 for _ in range(REPEATS)]
                    print(
                        f"{number.name:8} {how:9} median {statistics.median(times):4.0f} ms, "
                        f"longest {max(times):4.0f} ms",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
