"""How long it takes until a message of a ROS 2 system is in a scenario: `python benchmarks/ros2_actions.py`.

A node in another process publishes texts of 55 digits, the time of their sending, through a router in a third. A
coroutine waits for them, and after that a scenario does, whose variable follows the topic (`topic_monitor`); the
time is taken when the trace is told of the change. Both take turns.
"""

import asyncio
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from ros2_wire import ENDPOINT, STRING, another_of, show

import seoro
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh

MESSAGES = 500
ROUNDS = 3
PERIODS = (0.005, 0.001)  # [s]
SCENARIO = """import osc.ros

scenario main:
    var sent: string = ""
    do topic_monitor("/stamps", "std_msgs/msg/String", sent, member_name: "data")
"""


class Times:
    """An observer that measures how old what a variable holds is; `full` is set when there are enough."""

    def __init__(self) -> None:
        self.taken: list[float] = []
        self.full = asyncio.Event()

    def record(self, record: dict[str, Any]) -> None:
        """Called with each record of the trace."""
        if record["kind"] == "variable" and record["value"]:
            self.taken.append((time.time_ns() - int(record["value"])) / 1e3)
            if len(self.taken) == MESSAGES:
                self.full.set()


async def publish(period: float) -> None:
    """The other node."""
    async with (
        connect(ENDPOINT, dialect=RmwZenoh()) as system,
        system.node("talker") as node,
        node.publishing("/stamps", STRING) as publication,
    ):
        print("ready", flush=True)
        while True:
            await asyncio.sleep(period)
            publication.publish({"data": f"{time.time_ns():055d}"})


async def coroutine(node: RosNode) -> list[float]:
    """[us] from sending to the coroutine, for each message."""
    times = []
    async with node.subscribing("/stamps", STRING) as subscription:
        for _ in range(MESSAGES):
            message = await subscription.message()
            times.append((time.time_ns() - int(message.data)) / 1e3)
    return times[MESSAGES // 10 :]


async def scenario(loaded: seoro.Scenario) -> list[float]:
    """[us] from sending to the trace, for each message."""
    times = Times()
    async with seoro.start(loaded, ros=seoro.Ros(ENDPOINT, dialect="rmw_zenoh"), observers=(times,)):
        await times.full.wait()
    return times.taken[MESSAGES // 10 :]


async def measure(period: float, loaded: seoro.Scenario) -> None:
    """Print what was measured."""
    direct, through = [], []
    async with connect(ENDPOINT, dialect=RmwZenoh()) as system, system.node("listener") as node:
        for _ in range(ROUNDS):
            direct += await coroutine(node)
            through += await scenario(loaded)
    show(f"{1 / period:.0f}/s, to a coroutine", direct)
    show(f"{1 / period:.0f}/s, to a scenario", through)


def main() -> None:
    """All of it, or one role."""
    if len(sys.argv) > 1:
        asyncio.run(publish(float(sys.argv[1])))
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "main.osc"
        file.write_text(SCENARIO)
        loaded = seoro.load(file)
        with another_of("ros2_wire.py", "router"):
            for period in PERIODS:
                with another_of("ros2_actions.py", str(period)):
                    asyncio.run(measure(period, loaded))


if __name__ == "__main__":
    main()
