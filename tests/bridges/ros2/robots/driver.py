"""A run that drives a robot, for tests that kill it: `python driver.py ENDPOINT ROBOT (velocity|goal)`."""

from __future__ import annotations

import sys
from functools import partial

import anyio

from seoro.bridges.robot.connecting import connect_robots
from seoro.robotics.geometry import Pose3D, Position3D


async def main(endpoint: str, robot: str, how: str) -> None:
    """Drive until the process is killed; print `ready` at the start."""
    async with connect_robots(endpoint, "a run that dies") as node:
        if how == "velocity":
            await node.drive(robot, 0.2, 0.0, 60.0, print)
        else:
            await node.navigate(robot, [Pose3D(Position3D(x=90.0))], stop_at_each=False, report=print)
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(partial(main, *sys.argv[1:]))
