"""Latency, load and ends of seoro among genuine ROS 2 nodes (rclpy over rmw_zenoh).

    python benchmarks/ros2_genuine.py [latency] [bridge] [load] [ends] [--rounds N]

It needs a folder with a runtime of ROS 2 (`SEORO_ROS2_RUNTIME`, as the tests with genuine nodes do). All processes
use a router of Zenoh 1.8.0, in turns of the same run:

- latency: round trips of messages (`Header` of 64 bytes, `Image` of 1 MB) that an rclpy node returns, from rclpy
  and from seoro.
- bridge: round trips of velocities to such a node, published by seoro, and by a bridge that is asked for them.
- load: processor time of a bridge with one robot (odometry 50 Hz, scans 10 Hz, transforms 100 Hz), held by a run.
- ends: time from SIGKILL until the nodes of a process have left the graph, and the robot gets zero velocity.
"""

from __future__ import annotations

import argparse
import asyncio
import ctypes
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import uvloop

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import Qos

sys.path.insert(0, str(Path(__file__).parents[1]))

from processes import children, processor_time

from tests.bridges.ros2.genuine.conftest import SETUP, environment
from tests.bridges.ros2.robots.test_safety import DRIVER
from tests.routers import free_endpoint

NODES = Path(__file__).with_name("ros2_genuine_node.py")
TWIST = "geometry_msgs/msg/Twist"
PADDING = 47  # in a `Header` of 64 bytes: 4 of CDR, 8 of the stamp, 4 of the length, and a zero
MEGABYTE = 1_000_000
DEEP = Qos(depth=100)
CASES = (
    ("Header", PADDING, 10.0, 60),
    ("Header", PADDING, 200.0, 800),
    ("Header", PADDING, 1000.0, 3000),
    ("Image", MEGABYTE, 10.0, 60),
    ("Image", MEGABYTE, 30.0, 150),
)
DRIVES = 200
DRIVE_TIME = 0.1  # [s]
LOAD_TIME = 20.0  # [s]
PATIENCE = 60.0  # [s]
SPEED = 0.2  # [m/s]
LIBC = ctypes.CDLL(None)

Environment = dict[str, str]


class Place:
    """A router with genuine nodes.

    Args:
        runtime: Folder of the environment that `setup.sh` made.
    """

    def __init__(self, runtime: Path) -> None:
        self._runtime = runtime
        self.router = free_endpoint()

    @contextmanager
    def open(self) -> Iterator[Place]:
        """Run the router during the block."""
        port = self.router.rpartition(":")[2]
        with started([str(self._runtime / "router"), port], "router up"):
            yield self

    @contextmanager
    def node(self, *arguments: str) -> Iterator[subprocess.Popen[str]]:
        """Run a genuine node during the block."""
        with started(
            [str(self._runtime / "run"), str(NODES), *arguments], "ready", {"ROUTER": self.router}
        ) as node:
            yield node

    @contextmanager
    def bridge(self, folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
        """Run a bridge to a robot without a namespace during the block; yields it and its endpoint."""
        endpoint = f"unixsock-stream/{folder}/bridge"
        command = seoro(
            "bridge", "ros2", "--robot", "turtlebot4:robot", "--ros", self.router, "--listen", endpoint
        )
        with started(command, endpoint) as bridge:
            yield bridge, endpoint


def seoro(*arguments: str) -> list[str]:
    """Return a command of seoro."""
    return [sys.executable, "-m", "seoro", *arguments]


@contextmanager
def started(
    command: Sequence[str], begun: str, more: Environment | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Run a process that has printed a line with a text; it is killed at the end of the block."""
    environment = {**os.environ, **(more or {})}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
    ) as process:
        try:
            printed(process, begun)
            yield process
        finally:
            process.kill()


def printed(process: subprocess.Popen[str], text: str) -> str:
    """Wait for a line with a text, and return it."""
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        if text in line:
            return line
        lines.append(line)
    raise RuntimeError(f"the process ended without {text!r}: {''.join(lines[-10:])}")


# -------------------------------------------------------- latency


def measure_latency(place: Place, rounds: int) -> None:
    """Print round trips from rclpy and from seoro, in turns."""
    print(f"{'message':>9} {'rate':>6}  {'rclpy: median, 99 %':24} {'seoro: median, 99 %':24} ratios")
    with place.node("echo"):
        for kind, size, rate, count in CASES:
            case = (kind, str(size), str(rate), str(count))
            times: dict[str, list[float | None]] = {"rclpy": [], "seoro": []}
            for _ in range(rounds):
                with place.node("ping", *case) as pinger:
                    times["rclpy"] += json.loads(printed(pinger, "["))
                with started([sys.executable, __file__, "--ping", place.router, *case], "ready") as pinger:
                    times["seoro"] += json.loads(printed(pinger, "["))
            print(f"{kind:>9} {rate:6.0f}  {compared(times['rclpy'], times['seoro'])}", flush=True)


def compared(peer: Sequence[float | None], own: Sequence[float | None]) -> str:
    """Return medians and percentiles of both sides [ns], and how many times ours are theirs."""
    sides = [sorted(each for each in side if each is not None) for side in (peer, own)]
    medians = [statistics.median(side) for side in sides]
    tails = [side[int(0.99 * (len(side) - 1))] for side in sides]
    lost = [side.count(None) for side in (peer, own)]
    shown = [
        f"{median / 1e6:.2f}, {tail / 1e6:.2f} ms{f', {count} lost' if count else ''}"
        for median, tail, count in zip(medians, tails, lost, strict=True)
    ]
    return f"{shown[0]:24} {shown[1]:24} {medians[1] / medians[0]:.2f}, {tails[1] / tails[0]:.2f}"


@contextmanager
def ticking(rate: float, tick: Callable[[], None]) -> Iterator[None]:
    """Call a function at a rate [Hz] in the event loop during the block, as exactly as timers of rclpy.

    Event loops round sleeps to milliseconds, so two messages of a thousand per second may come at once.
    """
    timer = LIBC.timerfd_create(time.CLOCK_MONOTONIC, os.O_NONBLOCK)
    times = divmod(round(1e9 / rate), 1_000_000_000)  # seconds and nanoseconds
    LIBC.timerfd_settime(timer, 0, (ctypes.c_int64 * 4)(*times, *times), None)
    loop = asyncio.get_running_loop()

    def ring() -> None:
        os.read(timer, 8)  # the number of expirations: late ones are left out, as by rclpy
        tick()

    loop.add_reader(timer, ring)
    try:
        yield
    finally:
        loop.remove_reader(timer)
        os.close(timer)


async def ping(router: str, kind: str, size: int, rate: float, count: int) -> None:
    """Publish on /ping_KIND, and print the times until the echoes [ns]."""
    type_name = f"{'std_msgs' if kind == 'Header' else 'sensor_msgs'}/msg/{kind}"
    sent: dict[int, int] = {}
    taken: dict[int, int] = {}
    async with (
        connect(router) as system,
        system.node("pinger") as node,
        node.publishing(f"/ping_{kind}", type_name, DEEP) as publication,
        node.subscribing(f"/pong_{kind}", type_name, DEEP) as subscription,
    ):

        async def receive() -> None:
            while len(taken) < count:
                message = await subscription.message()
                taken[message.stamp.sec if kind == "Header" else message.height] = time.perf_counter_ns()

        await publication.wait_for_subscription(PATIENCE)
        print("ready", flush=True)
        receiving = asyncio.ensure_future(receive())
        await asyncio.sleep(1.0)
        text, data, over = "x" * size, bytes(size), asyncio.Event()

        def send() -> None:
            number = len(sent)
            if number == count:
                over.set()
                return
            sent[number] = time.perf_counter_ns()
            if kind == "Header":
                publication.publish({"stamp": {"sec": number}, "frame_id": text})
            else:
                publication.publish({"height": number, "data": data})

        with ticking(rate, send):
            await over.wait()
        await asyncio.wait([receiving], timeout=2.0)
        receiving.cancel()
    print(json.dumps([taken[each] - at if each in taken else None for each, at in sent.items()]), flush=True)


# -------------------------------------------------------- bridge


async def measure_bridge(place: Place, folder: Path) -> None:
    """Print round trips of velocities, directly and through a bridge, in turns."""
    times: dict[str, list[float]] = {"directly": [], "by the bridge": []}
    with place.node("robot"), place.node("echo"), place.bridge(folder) as (_, endpoint):
        async with (
            connect_robots(endpoint, "a benchmark") as robots,
            connect(place.router) as system,
            system.node("driver") as node,
            node.publishing("/cmd_vel", TWIST, DEEP) as publication,
            node.subscribing("/seen_vel", TWIST, DEEP) as subscription,
        ):
            await publication.wait_for_subscription(PATIENCE)

            async def returned(speed: float) -> int:
                while abs((await subscription.message()).linear.x - speed) > 1e-9:
                    pass
                return time.perf_counter_ns()

            for number in range(2 * DRIVES):
                speed, how = SPEED + number * 1e-4, list(times)[number % 2]
                waiting = asyncio.ensure_future(returned(speed))
                await asyncio.sleep(0.02)
                ended = asyncio.Event()
                begun = time.perf_counter_ns()
                if how == "directly":
                    publication.publish({"linear": {"x": speed}})
                    ended.set()
                else:
                    await robots.drive("robot", speed, 0.0, DRIVE_TIME, lambda *_, ended=ended: ended.set())
                times[how].append((await asyncio.wait_for(waiting, PATIENCE) - begun) / 1e6)
                await asyncio.wait_for(ended.wait(), PATIENCE)
    medians = {how: statistics.median(each) for how, each in times.items()}
    shown = ", ".join(f"{how} {median:.2f} ms" for how, median in medians.items())
    print(f"velocities and back: {shown}; the bridge adds {medians['by the bridge'] - medians['directly']:.2f} ms")


# -------------------------------------------------------- load


async def measure_load(place: Place, folder: Path) -> None:
    """Print the share of a core that a bridge takes, with and without a run that holds its robot."""
    with place.node("robot"), place.bridge(folder) as (bridge, endpoint):
        idle = await share_of(bridge.pid)
        async with connect_robots(endpoint, "a benchmark"):
            held = await share_of(bridge.pid)
    print(f"bridge and guard: {100 * idle:.1f} % of a core, {100 * held:.1f} % with a run that holds the robot")


async def share_of(process: int) -> float:
    """Return the share of a core that a process and its children take."""
    await asyncio.sleep(2.0)
    tree = [process, *children(process)]
    before = sum(processor_time(each) for each in tree)
    await asyncio.sleep(LOAD_TIME)
    return (sum(processor_time(each) for each in tree) - before) / LOAD_TIME


# -------------------------------------------------------- ends


def measure_ends(place: Place, folder: Path, rounds: int) -> None:
    """Print how long the nodes of killed processes are seen, and their robot drives."""
    scenario = folder / "waits.osc"
    scenario.write_text("import osc.helpers\nscenario waits:\n    do serial:\n        wait elapsed(600s)\n")
    commands = {
        "a run": seoro("exec", str(scenario), "--ros", place.router),
        "an echo": seoro("ros", "topic", "echo", "/odom", "--ros", place.router),
    }
    with place.node("robot") as robot, place.node("watch") as watcher:
        for whom, command in commands.items():
            print(
                f"{whom}: gone after {spread([gone_after(command, watcher) for _ in range(rounds)])}", flush=True
            )
        gone, stopped = [], []
        for number in range(rounds):
            own = folder / str(number)
            own.mkdir()
            with (
                place.bridge(own) as (bridge, endpoint),
                started([sys.executable, DRIVER, endpoint, "robot", "velocity"], "ready"),
            ):
                while float(printed(robot, "velocity").split()[2]) == 0.0:
                    pass
                seen_with(watcher, "seoro")
                tree = children(bridge.pid)
                moment = time.monotonic()
                bridge.send_signal(signal.SIGKILL)
                while float((line := printed(robot, "velocity")).split()[2]):
                    pass
                stopped.append(float(line.split()[1]) - moment)
                for each in tree:
                    with suppress(ProcessLookupError):
                        os.kill(each, signal.SIGKILL)
                gone.append(seen_without(watcher, "seoro") - moment)
        print(f"a bridge: stopped after {spread(stopped)}, gone after {spread(gone)}", flush=True)


def gone_after(command: Sequence[str], watcher: subprocess.Popen[str]) -> float:
    """Return the time from the end of a process until its nodes are not seen [s]."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            seen_with(watcher, "seoro")
        finally:
            moment = time.monotonic()
            process.kill()
    return seen_without(watcher, "seoro") - moment


def seen_with(watcher: subprocess.Popen[str], text: str) -> None:
    """Wait until a node with a text in its name is seen."""
    while text not in printed(watcher, "graph"):
        pass


def seen_without(watcher: subprocess.Popen[str], text: str) -> float:
    """Wait until no node with a text in its name is seen; returns the time of the machine [s]."""
    while text in (line := printed(watcher, "graph")):
        pass
    return float(line.split()[1])


def spread(times: Sequence[float]) -> str:
    """Return the median and the longest of times [s]."""
    return f"{1e3 * statistics.median(times):.0f} ms (longest {1e3 * max(times):.0f})"


def main() -> None:
    """Measure and print."""
    if sys.argv[1:2] == ["--ping"]:
        router, kind, size, rate, count = sys.argv[2:]
        uvloop.run(ping(router, kind, int(size), float(rate), int(count)))
        return
    parser = argparse.ArgumentParser(description="Measure seoro among genuine ROS 2 nodes.")
    parts = ("latency", "bridge", "load", "ends")
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(parts)} (default: all)")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    if unknown := set(options.parts) - set(parts):
        parser.error(f"unknown part {min(unknown)!r}; expected {', '.join(parts)}")
    chosen = options.parts or parts
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with Place(environment(SETUP)).open() as place:
            if "latency" in chosen:
                measure_latency(place, options.rounds)
            if "bridge" in chosen:
                uvloop.run(measure_bridge(place, folder))
            if "load" in chosen:
                uvloop.run(measure_load(place, folder))
            if "ends" in chosen:
                measure_ends(place, folder, 4 * options.rounds)


if __name__ == "__main__":
    main()
