"""Latency from a ROS 2 message to the reaction of a scenario: `python benchmarks/ros2_latency.py`.

Messages of 64 bytes come from a process of their own, through a router in a third. Times are from just before a
message is put until, in turns,

- bare: the callback has it, between two processes with Zenoh and nothing else. That is Zenoh's and the machine's.
- thread: Zenoh's thread has it, between a node of seoro's and a process with an event loop.
- coroutine: the coroutine that waits for it has it.
- scenario: the action starts that follows a `wait` for a variable, which `topic_monitor` lets follow the topic.

A machine that has nothing to do sleeps, and wakes up late: with `--awake`, which takes root's rights, its
processors are kept from that, as those of real-time systems are. The event loop is that of `seoro exec --ros`,
uvloop. All processes read the same monotonic clock. Printed are medians of all messages, the lowest and the
highest median of a round, and the 99th percentile.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import statistics
import struct
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import uvloop
import zenoh
from ros2_wire import ENDPOINT, another_of

import seoro
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import Bound

TYPE = "std_msgs/msg/Header"
TOPIC = "/numbers"
KEY = "numbers"
PADDING = "x" * 47  # after 4 bytes of CDR's header, 8 of the stamp and 4 of the length, before a zero: 64 bytes
MESSAGES = 300  # in a round, for each
WARM_UP = 30  # of these, which do not count
PERIODS = (0.005, 0.001)  # [s]
LIMIT = 500.0  # [us] that the median may be, to the scenario
SETTLING = 0.3  # [s] until a subscription is known everywhere
SCENARIO = f"""import osc.helpers
import osc.ros

scenario main:
    var number: int = 0
    do parallel:
        topic_monitor("{TOPIC}", "{TYPE}", number, member_name: "stamp.sec")
        serial:
"""
TYPES = TypeStore.bundled()

Times = Mapping[int, int]  # [ns], by the numbers of messages


# -------------------------------------------------------- the other processes


def publish_round(line: str, put: Callable[[int], None]) -> None:
    """Publish messages at the rate given by a line of input; print the time of each [ns]."""
    period = float(line)
    times = {}
    for number in range(1, MESSAGES + 1):
        time.sleep(period)
        times[number] = time.perf_counter_ns()
        put(number)
    print(json.dumps(times), flush=True)


def bare_session() -> zenoh.Session:
    """A client of the router."""
    config = {
        "mode": "client",
        "connect": {"endpoints": [ENDPOINT]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {"shared_memory": {"enabled": False}},
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))


def bare_talker() -> None:
    """Publish rounds, by Zenoh alone."""
    with bare_session() as session:
        publisher = session.declare_publisher(KEY)
        print("ready", flush=True)
        for line in sys.stdin:
            publish_round(line, lambda number: publisher.put(number.to_bytes(64, "little")))


def bare_listener() -> None:
    """Record arrival times by Zenoh alone; print them for each line of the input [ns]."""
    times: dict[int, int] = {}

    def take(sample: zenoh.Sample) -> None:
        now = time.perf_counter_ns()
        times[int.from_bytes(sample.payload.to_bytes(), "little")] = now

    with bare_session() as session:
        session.declare_subscriber(KEY, zenoh.handlers.Callback(take, indirect=False))
        print("ready", flush=True)
        for _ in sys.stdin:
            print(json.dumps(times), flush=True)
            times.clear()


async def talker() -> None:
    """Publish rounds, as a node of seoro's."""
    contents = [TYPES.encode(TYPE, {"stamp": {"sec": n}, "frame_id": PADDING}) for n in range(MESSAGES + 1)]
    assert len(contents[0]) == 64
    async with (
        connect(ENDPOINT, types=TYPES, dialect=RmwZenoh()) as system,
        system.node("talker") as node,
        node.publishing(TOPIC, TYPE) as publication,
    ):
        print("ready", flush=True)
        while line := await asyncio.to_thread(sys.stdin.readline):
            publish_round(line, lambda number: publication.send(contents[number]))


class Partner:
    """Child process with one line per request and answer."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    def write_line(self, what: object) -> None:
        """Send a line."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{what}\n".encode())

    async def answer(self) -> Times:
        """Return the answer."""
        assert self._process.stdout is not None
        return {int(number): at for number, at in json.loads(await self._process.stdout.readline()).items()}


@asynccontextmanager
async def partner(role: str) -> AsyncIterator[Partner]:
    """Start a process of this script with a role."""
    command = [sys.executable, __file__, "--role", role]
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(*command, stdin=pipe, stdout=pipe, limit=1 << 20)
    assert process.stdout is not None
    try:
        await process.stdout.readline()
        yield Partner(process)
    finally:
        process.kill()
        await process.wait()


# -------------------------------------------------------- rounds


def since(sent: Times, arrived: Times) -> list[float]:
    """Return the latencies of arrived messages [us]."""
    return [(at - sent[number]) / 1e3 for number, at in arrived.items() if number > WARM_UP]


async def bare(talking: Partner, listening: Partner, period: float) -> dict[str, list[float]]:
    """Measure a round of Zenoh alone."""
    talking.write_line(period)
    sent = await talking.answer()
    await asyncio.sleep(SETTLING)
    listening.write_line("")
    return {"bare": since(sent, await listening.answer())}


async def coroutine(node: RosNode, talking: Partner, period: float) -> dict[str, list[float]]:
    """Measure a round to a coroutine."""
    arrived, taken = {}, {}
    async with node.subscribing(TOPIC, TYPE, bound=Bound(MESSAGES)) as subscription:
        await asyncio.sleep(SETTLING)
        talking.write_line(period)
        number = 0
        while number < MESSAGES:
            received = await subscription.receive()
            number = subscription.decode(received).stamp.sec
            taken[number] = time.perf_counter_ns()
            arrived[number] = taken[number] - (time.time_ns() - received.arrived)
        sent = await talking.answer()
    return {"thread": since(sent, arrived), "coroutine": since(sent, taken)}


class Starts:
    """An observer that takes the times at which the action `log` starts; the first is that of no message."""

    def __init__(self) -> None:
        self.times: list[int] = []
        self.is_ready = asyncio.Event()
        self.is_over = asyncio.Event()

    def record(self, record: dict[str, Any]) -> None:
        """Called with each record of the trace."""
        if record["kind"] == "behavior.start" and record["name"] == "log":
            self.times.append(time.perf_counter_ns())
            self.is_ready.set()
            if len(self.times) > MESSAGES:
                self.is_over.set()


async def scenario(loaded: seoro.Scenario, talking: Partner, period: float) -> dict[str, list[float]]:
    """Measure a round to a scenario."""
    starts = Starts()
    async with seoro.start(loaded, ros=seoro.Ros(ENDPOINT, dialect="rmw_zenoh"), observers=(starts,)):
        await starts.is_ready.wait()
        await asyncio.sleep(SETTLING)
        talking.write_line(period)
        await starts.is_over.wait()
        sent = await talking.answer()
    return {"scenario": since(sent, dict(enumerate(starts.times)))}


def load(folder: Path) -> seoro.Scenario:
    """Return a scenario that waits for numbers in turn, and logs each."""
    waits = [
        f"            wait number >= {number}\n            log('{number}')" for number in range(1, MESSAGES + 1)
    ]
    file = folder / "main.osc"
    file.write_text(SCENARIO + "\n".join(["            log('0')", *waits, ""]))
    return seoro.load(file)


async def measure(rounds: int, loaded: seoro.Scenario) -> None:
    """Measure everything, in turns."""
    async with (
        partner("bare-talker") as bare_talking,
        partner("bare-listener") as bare_listening,
        partner("talker") as talking,
        connect(ENDPOINT, types=TYPES, dialect=RmwZenoh()) as system,
        system.node("listener") as node,
    ):
        TYPES.decode(TYPE, TYPES.encode(TYPE, {}))  # the first time takes longer
        for period in PERIODS:
            found: dict[str, list[list[float]]] = {}
            for _ in range(rounds):
                measured = await bare(bare_talking, bare_listening, period)
                measured |= await coroutine(node, talking, period)
                measured |= await scenario(loaded, talking, period)
                for name, times in measured.items():
                    found.setdefault(name, []).append(times)
            report(period, found)


def report(period: float, found: Mapping[str, Sequence[list[float]]]) -> None:
    """Print the measurements: rounds by name."""
    print(f"{1 / period:.0f} a second; load of the machine {os.getloadavg()[0]:.1f}")
    medians = {}
    for name, rounds in found.items():
        every = sorted(each for times in rounds for each in times)
        each_round = [statistics.median(times) for times in rounds]
        medians[name] = statistics.median(every)
        span = f"{min(each_round):.0f} to {max(each_round):.0f}"
        p99 = every[len(every) * 99 // 100]
        print(f"  {name:10} p50 {medians[name]:5.0f} us  rounds {span:12}  p99 {p99:6.0f} us")
    whole = medians["scenario"]
    verdict = "met" if whole < LIMIT else "not met"
    print(f"  {whole:.0f} us, of which {whole - medians['bare']:.0f} are seoro's; limit {LIMIT:.0f} us: {verdict}")


@contextmanager
def awake() -> Iterator[None]:
    """Keep the processors awake: Linux allows no wake-up latency while this file is open."""
    with Path("/dev/cpu_dma_latency").open("wb", buffering=0) as latency:
        latency.write(struct.pack("i", 0))  # [us]
        yield


def main() -> None:
    """Run everything, or one role."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--awake", action="store_true", help="keep the processors from sleeping")
    parser.add_argument("--role", help=argparse.SUPPRESS)
    options = parser.parse_args()
    match options.role:
        case "bare-talker":
            bare_talker()
        case "bare-listener":
            bare_listener()
        case "talker":
            asyncio.run(talker())
        case _:
            with (
                tempfile.TemporaryDirectory() as folder,
                another_of("ros2_wire.py", "router"),
                awake() if options.awake else nullcontext(),
                asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner,
            ):
                runner.run(measure(options.rounds, load(Path(folder))))


if __name__ == "__main__":
    main()
