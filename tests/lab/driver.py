"""A run that drives one robot, for tests that kill it: `python driver.py ENDPOINT ROBOT`."""

from __future__ import annotations

import sys

import anyio

from seoro.bridges.robot.connecting import connect_robots


async def main() -> None:
    """Drive until the process is killed."""
    endpoint, robot = sys.argv[1:]
    async with connect_robots(endpoint, "a run that dies", robots=(robot,)) as node:
        await node.drive(robot, 0.2, 0.3, 600.0, lambda report: None)
        sys.stdout.write("drives\n")
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(main)
