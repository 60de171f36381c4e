"""Time of an emergency stop, from the request to the answer, and until a robot stands still.

    python benchmarks/emergency_stop.py [--rounds N]

The robot drives in a simulator that plays in real time. Without a bridge, the true speed of
the simulator counts; with a bridge to ROS 2, the first velocity of zero on the wire.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import tempfile
import time
from pathlib import Path

from processes import command

from seoro.bridges import wire
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.session import Sample, open_session, subscribing
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.lab.commands import LabCommands
from seoro.lab.outcomes import Outcome

ROBOT, SPEED, STILL = "turtlebot4", 0.3, 0.01  # [m/s]
COMMANDS = f"0/{ROBOT}/cmd_vel/**"
CDR_HEADER = 4  # [bytes]
UP_TO_SPEED = 1.0  # [s]
GOAL = 0.3  # [s]


async def _stop_in_full_motion(endpoint: str) -> tuple[Outcome, float]:
    """Drive the robot and stop it; return the result, and the start of the stop [s]."""
    async with connect_robots(endpoint, "a benchmark", robots=(ROBOT,)) as node:
        await node.drive(ROBOT, SPEED, 0.0, 60.0, lambda report: None)
        await asyncio.sleep(UP_TO_SPEED)
        began = time.monotonic()
        (outcome,) = await LabCommands([endpoint]).emergency_stop_all("a benchmark", "to measure it")
        return outcome, began


async def in_simulator(endpoint: str) -> tuple[float, float]:
    """Return the time until the answer, and until the robot stands still [s]."""
    async with open_session(connect=endpoint) as session:
        address = NodeAddress(session, wire.NAMESPACE, "mujoco")
        outcome, began = await _stop_in_full_motion(endpoint)
        while True:
            state = await ask(address, wire.GET_ENTITY_STATE, wire.EntityName(name=ROBOT))
            if abs(state.twist.linear.x) + abs(state.twist.linear.y) < STILL:
                break
        still = time.monotonic()
    await LabCommands([endpoint]).release_all("a benchmark", "it is measured")
    return outcome.elapsed, still - began


async def behind_bridge(endpoint: str, ros: str) -> tuple[float, float]:
    """Return the time until the answer, and until a velocity of zero is on the wire [s]."""
    zeros: list[float] = []

    def take(sample: Sample) -> None:
        if not any(sample.payload[CDR_HEADER:]):
            zeros.append(time.monotonic())

    async with open_session(connect=ros) as session, subscribing(session, COMMANDS, take):
        outcome, began = await _stop_in_full_motion(endpoint)
    await LabCommands([endpoint]).release_all("a benchmark", "it is measured")
    return outcome.elapsed, next(when for when in zeros if when > began) - began


def show(where: str, what: str, times: list[tuple[float, float]]) -> None:
    """Print medians and the longest."""
    for name, column in (("answer", 0), (what, 1)):
        found = [each[column] * 1000.0 for each in times]
        print(f"{where}, {name}: {statistics.median(found):.0f} ms, at most {max(found):.0f} ms")
    late = sum(each[1] > GOAL for each in times)
    print(f"{where}: {late} of {len(times)} took longer than {GOAL * 1000:.0f} ms")


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    rounds: int = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        simulator, ros, bridge = (f"unixsock-stream/{folder}/{each}" for each in ("simulator", "ros", "bridge"))
        with command("sim", "mujoco", "--world", "hall", "--rate", "1", "--listen", simulator):
            show("in a simulator", "still", [asyncio.run(in_simulator(simulator)) for _ in range(rounds)])
            robot = f"turtlebot4:{ROBOT}@/{ROBOT}"
            with (
                command("bridge", "ros2", "--expose", "--simulator", simulator, "--ros-listen", ros),
                command("bridge", "ros2", "--robot", robot, "--ros", ros, "--listen", bridge),
            ):
                times = [asyncio.run(behind_bridge(bridge, ros)) for _ in range(rounds)]
                show("behind a bridge", "zero on the wire", times)


if __name__ == "__main__":
    main()
