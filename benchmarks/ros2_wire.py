"""Latency from a ROS 2 message to a waiting coroutine: `python benchmarks/ros2_wire.py`.

A node in another process publishes 64 bytes a thousand times a second, through a router in a third, and serves a
service. Times are those since sending, by the clock of this machine: until Zenoh's thread has the message, and
until the coroutine that waits for it goes on.
"""

import asyncio
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import Session

ENDPOINT = "tcp/127.0.0.1:17447"
STRING = "std_msgs/msg/String"
EMPTY = "std_srvs/srv/Empty"
TEXT = "x" * 55  # 4 bytes of header, 4 of length, and a zero: 64 bytes
MESSAGES = 3000
CALLS = 1000


async def publish() -> None:
    """Run the other node."""

    async def respond(_: Message) -> dict[str, object]:
        return {}

    async with (
        connect(ENDPOINT, dialect=RmwZenoh()) as system,
        system.node("talker") as node,
        node.serving("/respond", EMPTY, respond),
        node.publishing("/chatter", STRING) as publication,
    ):
        print("ready", flush=True)
        while True:
            await asyncio.sleep(0.001)
            publication.publish({"data": TEXT})


async def topic(node: RosNode) -> tuple[list[float], list[float]]:
    """Return the latency to Zenoh's thread and to the coroutine for each message [us]."""
    arrivals, times = [], []
    async with node.subscribing("/chatter", STRING) as subscription:
        for _ in range(MESSAGES):
            received = await subscription.receive()
            assert received.sent is not None and len(received.payload) == 64
            times.append((time.time_ns() - received.sent) / 1e3)
            arrivals.append((received.arrived - received.sent) / 1e3)
    return arrivals[MESSAGES // 10 :], times[MESSAGES // 10 :]


async def service(node: RosNode) -> list[float]:
    """Return the duration of each call [us]."""
    times = []
    async with node.calling("/respond", EMPTY) as client:
        await client.wait_for_server(5)
        for _ in range(CALLS):
            start = time.perf_counter()
            await client.call({}, timeout=5)
            times.append((time.perf_counter() - start) * 1e6)
    return times[CALLS // 10 :]


async def measure() -> None:
    """Print the measurements."""
    async with connect(ENDPOINT, dialect=RmwZenoh()) as system, system.node("listener") as node:
        arrivals, times = await topic(node)
        show("topic, 64 bytes, to Zenoh's thread", arrivals)
        show("topic, 64 bytes, to a coroutine", times)
        show("service, there and back", await service(node))


def show(name: str, times: list[float]) -> None:
    """Print median and 99th percentile."""
    ordered = sorted(times)
    p99 = ordered[len(ordered) * 99 // 100]
    print(f"{name:36} p50 {statistics.median(ordered):6.0f} us   p99 {p99:6.0f} us")


@contextmanager
def another_of(script: str, role: str) -> Iterator[None]:
    """Start another script of this folder with a role."""
    command = [sys.executable, str(Path(__file__).with_name(script)), role]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout is not None
    try:
        process.stdout.readline()
        yield
    finally:
        process.kill()
        process.wait()


def main() -> None:
    """Run everything, or one role."""
    match sys.argv[1:]:
        case ["router"]:
            hub = Session(listen=ENDPOINT, gossip=True)
            print("ready", flush=True)
            sys.stdin.read()
            hub.close()
        case ["publisher"]:
            asyncio.run(publish())
        case _:
            with another_of("ros2_wire.py", "router"), another_of("ros2_wire.py", "publisher"):
                asyncio.run(measure())


if __name__ == "__main__":
    main()
