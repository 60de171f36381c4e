"""A run that drives the robot on rails, for tests that kill it: `python driver.py ENDPOINT`."""

from __future__ import annotations

import sys

import anyio

from seoro.bridges.robot.connecting import connect_robots
from seoro.robotics.geometry import Pose3D, Position3D


def print_line(what: object) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{what}\n")
    sys.stdout.flush()


async def main() -> None:
    """Drive until the process is killed; print a line when the robot has its goal."""
    async with connect_robots(sys.argv[1], "a run that dies") as node:
        await node.navigate("line", [Pose3D(Position3D(x=90.0))], stop_at_each=False, report=print_line)
        print_line("drives")
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(main)
