"""A robot in a simulation: `python -m tests.actions.ros2.simulated_robot ENDPOINT`.

It publishes `/clock` from 1000 s on, fifty times a second. By this clock it stamps a scan, which is 50 ms old, and
the frame `base_link` in `odom`, which is at x = 5 m. Each line on stdin moves the frame by 5 m, and the clock by
the seconds on the line. It prints a line when it is ready, and ends with its stdin.
"""

import sys
from collections.abc import Mapping
from typing import Any

import anyio

from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from tests.actions.ros2.robot import transform

TICK = 0.02  # [s]
AGE = 0.05  # [s]


def stamp(time: float) -> Mapping[str, Any]:
    return {"sec": int(time), "nanosec": int(time % 1 * 1e9)}


async def main() -> None:
    now, x = 1000.0, 5.0

    async def listen() -> None:
        nonlocal now, x
        while line := await anyio.to_thread.run_sync(sys.stdin.readline, abandon_on_cancel=True):
            now, x = now + float(line), x + 5.0
        tasks.cancel_scope.cancel()

    async with (
        connect(sys.argv[1], dialect=RmwZenoh()) as system,
        system.node("robot") as node,
        node.publishing("/clock", "rosgraph_msgs/msg/Clock") as clock,
        node.publishing("/scan", "sensor_msgs/msg/LaserScan") as scan,
        node.publishing("/tf", "tf2_msgs/msg/TFMessage") as frames,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(listen)
        print("ready", flush=True)  # noqa: T201 - for who has started it
        while True:
            clock.publish({"clock": stamp(now)})
            scan.publish({"header": {"stamp": stamp(now - AGE), "frame_id": "laser"}})
            frames.publish({"transforms": [transform("odom", "base_link", x, now)]})
            await anyio.sleep(TICK)
            now += TICK


if __name__ == "__main__":
    anyio.run(main)
