"""Cost of streams for a simulator: python benchmarks/streams.py [--rounds N]

A robot navigates in the maze. It is simulated in turns without a stream, with a stream of the time alone, and
with all topics of an exposed robot: lidar, odometry, IMU, pose and joints. Published messages are encoded and
dropped. The lidar senses in all of them, since the robot navigates. Figures are simulated seconds per second,
medians of all rounds, and shares of the first.
"""

from __future__ import annotations

import argparse
import statistics
import time
from typing import Any

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import handle

ROBOT = "turtlebot4"
SLICE = 2.0  # [s] of simulated time in each turn
EVERYTHING = wire.OpenStream(
    id="all",
    sensors=tuple(wire.SensorName(robot=ROBOT, sensor=sensor) for sensor in ("lidar", "odometry", "imu")),
    poses=(ROBOT,),
    joints=(ROBOT,),
)
KINDS = {"none": None, "time": wire.OpenStream(id="time"), "everything": EVERYTHING}


class Sink:
    """Drops published messages."""

    has_subscribers = True

    def put(self, payload: bytes) -> None:
        """Drop a message."""

    def close(self) -> None:
        """Do nothing."""


def simulator(stream: wire.OpenStream | None) -> Simulator:
    """Return a client of a robot on a long path."""
    made = Simulator(ENGINES["mujoco"](), "maze", 3)
    made.streams.connect(lambda _: Sink())
    requests: list[tuple[wire.Verb[Any, Any], wire.Message]] = [
        (wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=ROBOT, pose=wire.Pose3D())),
        (wire.NAVIGATE_THROUGH_POSES, wire.NavigateThroughPoses(id="go", robot=ROBOT, poses=(FAR,))),
    ]
    if stream is not None:
        requests.append((wire.OPEN_STREAM, stream))
    for verb, request in requests:
        handle(made, verb.name, wire.encode(request))
    return made


FAR = wire.Pose3D(wire.Position3D(3.0, -3.0))


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=8)
    rounds = parser.parse_args().rounds
    simulators = {kind: simulator(stream) for kind, stream in KINDS.items()}
    rates: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for number in range(1, rounds + 1):
        for kind, each in simulators.items():
            begin = time.perf_counter()
            each.simulation.run(number * SLICE)
            rates[kind].append(SLICE / (time.perf_counter() - begin))
    for kind, measured in rates.items():
        shares = [one / none for one, none in zip(measured, rates["none"], strict=True)]
        print(f"{kind:10}  {statistics.median(measured):7.1f}  {statistics.median(shares):5.2f}")


if __name__ == "__main__":
    main()
