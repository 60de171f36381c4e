"""Cost of recording: large messages into a bag, and laser scans that are decoded and recorded.

    python benchmarks/bags.py [SECONDS]

Prints the share of a processor core of the recording process, first of the writer alone, then over Zenoh with a
robot in another process, behind a router. Nothing may be lost. Each measurement lasts SECONDS (20: 1 GB at 50
MB/s).
"""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.recording import BagTopic, BagWriter, open_bag, record, write_bag
from seoro.bridges.ros2.wire import Qos, RmwZenoh
from seoro.bridges.session import Bound, open_session
from seoro.concurrency.background import background

TYPES = TypeStore.bundled()
SCAN = "sensor_msgs/msg/LaserScan"
IMAGE = "sensor_msgs/msg/Image"
RATES = {SCAN: 1000, IMAGE: 50}  # [Hz]
TOPICS = {SCAN: "/scan", IMAGE: "/image"}
LIMIT = 0.6  # share of a core at which no message may be lost


def payload(type_name: str) -> bytes:
    """Return a scan of 720 beams with intensities, or an image of 1 MB."""
    if type_name == SCAN:
        return TYPES.encode(SCAN, {"ranges": [1.5] * 720, "intensities": [40.0] * 720})
    return TYPES.encode(
        IMAGE, {"width": 1000, "height": 1000, "encoding": "mono8", "step": 1000, "data": bytes(10**6)}
    )


async def paced(rate: float, seconds: float) -> AsyncIterator[int]:
    """Yield numbers at a rate [Hz]; late numbers follow immediately."""
    start = time.monotonic()
    for number in range(round(rate * seconds)):
        late = time.monotonic() - start - number / rate
        if late < 0:
            await asyncio.sleep(-late)
        yield number


class Cost:
    """Share of a core used by this process since its creation."""

    def __init__(self) -> None:
        self._started = time.monotonic(), time.process_time()

    def share(self) -> float:
        """Return the share so far."""
        wall, processor = self._started
        return (time.process_time() - processor) / (time.monotonic() - wall)


async def write_alone(folder: Path, type_name: str, seconds: float) -> None:
    """Write a bag of messages at a rate; scans are decoded, too."""
    content = payload(type_name)
    cost, slowest = Cost(), 0.0
    async with write_bag(folder) as writer:
        add(writer, type_name)
        async for _ in paced(RATES[type_name], seconds):
            begin = time.perf_counter()
            if type_name == SCAN:
                TYPES.decode(SCAN, content)
            writer.write(TOPICS[type_name], content, time.time_ns())
            slowest = max(slowest, time.perf_counter() - begin)
    report("writer alone", type_name, folder, cost, sum(writer.lost.values()))
    print(f"    the slowest call took {slowest * 1e3:.1f} ms")


def add(writer: BagWriter, type_name: str) -> None:
    """Add the topic of a type."""
    topic = BagTopic(TOPICS[type_name], type_name, TYPES.type_hash(type_name), (Qos(),))
    writer.add_topic(topic, TYPES.schema(type_name))


async def record_robot(folder: Path, type_name: str, seconds: float) -> None:
    """Record what a robot publishes over Zenoh; scans are decoded, too, as by an action that looks at them."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        router = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    robot = [sys.executable, __file__, "--robot", router, type_name, str(seconds)]
    process = await asyncio.create_subprocess_exec(*robot, stdout=subprocess.PIPE)
    assert process.stdout is not None
    await process.stdout.readline()  # the robot has connected
    async with (
        connect(router, types=TYPES, dialect=RmwZenoh()) as system,
        system.node("recorder") as node,
        background() as tasks,
        record(node, folder, [TOPICS[type_name]], on_note=print) as recording,
    ):
        if type_name == SCAN:
            tasks.start_soon(decode, node)
        await recording.wait_complete()
        cost = Cost()
        await process.wait()
    lost, missed = sum(recording.lost.values()), sum(recording.missed.values())
    report("over Zenoh", type_name, folder, cost, lost, missed)


async def decode(node: RosNode) -> None:
    """Decode all scans."""
    async with node.subscribing(TOPICS[SCAN], SCAN, Qos(), Bound(10_000)) as subscription:
        while True:
            await subscription.message()


async def be_robot(router: str, type_name: str, seconds: float) -> None:
    """Publish messages as the robot process."""
    content = payload(type_name)
    async with (
        open_session(listen=router, gossip=True),
        connect(router, types=TYPES, dialect=RmwZenoh()) as system,
        system.node("robot") as node,
        node.publishing(TOPICS[type_name], type_name) as publication,
    ):
        print("there", flush=True)
        await publication.wait_for_subscription()
        await asyncio.sleep(0.5)
        async for _ in paced(RATES[type_name], seconds):
            publication.send(content)
        await asyncio.sleep(0.5)


def report(how: str, type_name: str, folder: Path, cost: Cost, lost: int, missed: int = 0) -> None:
    """Print the measurement."""
    share = cost.share()
    bag = open_bag(folder)
    size = sum(file.stat().st_size for file in folder.iterdir())
    seconds = (bag.extent.end - bag.extent.start) / 1e9
    what = f"{bag.extent.count / seconds:.0f} {TOPICS[type_name]} a second, {size / seconds / 1e6:.0f} MB/s"
    print(f"{how}: {what}, {size / 1e9:.2f} GB: {share:.0%} of a core, {lost} lost, {missed} did not arrive")
    verdict = "met" if share < LIMIT and not lost and not missed else "not met"
    load = os.getloadavg()[0]
    print(f"    limit {LIMIT:.0%} of a core and nothing lost: {verdict}; load of the machine {load:.1f}")
    shutil.rmtree(folder)


async def main(seconds: float) -> None:
    """Measure everything."""
    with tempfile.TemporaryDirectory() as folder:
        for type_name in (IMAGE, SCAN):
            await write_alone(Path(folder, "alone"), type_name, seconds)
            await record_robot(Path(folder, "robot"), type_name, seconds)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--robot", router, type_name, seconds]:
            asyncio.run(be_robot(router, type_name, float(seconds)))
        case arguments:
            asyncio.run(main(float(arguments[0]) if arguments else 20.0))
