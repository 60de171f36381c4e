"""Cost of encoding and decoding ROS 2 messages with seoro and with rosbags alone, and of the first message.

    python benchmarks/ros2_interfaces.py [--rounds N]

Each round takes all measures in turn. Processor times are medians of the rounds: microseconds for a message, and
milliseconds for the first message of a new Python. That Python has imported numpy and the modules of each
`seoro exec`. rosbags gets messages of its own classes, without checks; seoro gets plain values of scenarios, or a
decoded message.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
import timeit
from collections.abc import Callable
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from seoro.bridges.ros2.interfaces import TypeStore

HEADER = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "base_link"}
TRANSFORM = {"header": HEADER, "child_frame_id": "odom", "transform": {"translation": {"x": 1.5}}}
MESSAGES: dict[str, tuple[str, dict[str, Any]]] = {
    "String": ("std_msgs/msg/String", {"data": "hello"}),
    "Twist": ("geometry_msgs/msg/Twist", {"linear": {"x": 0.5}, "angular": {"z": -0.2}}),
    "JointState of 7": (
        "sensor_msgs/msg/JointState",
        {"header": HEADER, "name": [f"joint_{number}" for number in range(7)], "position": np.zeros(7)},
    ),
    "Odometry": ("nav_msgs/msg/Odometry", {"header": HEADER, "child_frame_id": "base_link"}),
    "TF of 1": ("tf2_msgs/msg/TFMessage", {"transforms": [TRANSFORM]}),
    "TF of 20": ("tf2_msgs/msg/TFMessage", {"transforms": [TRANSFORM] * 20}),
    "LaserScan of 720": (
        "sensor_msgs/msg/LaserScan",
        {"header": HEADER, "ranges": np.ones(720, np.float32), "intensities": np.ones(720, np.float32)},
    ),
    "Image 640 x 480": (
        "sensor_msgs/msg/Image",
        {"header": HEADER, "height": 480, "width": 640, "step": 1920, "data": np.zeros(921600, np.uint8)},
    ),
}
FIRST = {
    "type hash": "type_hash('sensor_msgs/LaserScan')",
    "LaserScan": "encode('sensor_msgs/LaserScan', {})",
    "Odometry": "encode('nav_msgs/Odometry', {})",
}
PROGRAM = """
import numpy, seoro.embed, time
start = time.process_time()
from seoro.bridges.ros2.interfaces import TypeStore
TypeStore.bundled().{work}
print(time.process_time() - start)
"""
COLUMNS = ("seoro: values", "message", "decode", "rosbags: encode", "decode")


def microseconds(work: Callable[[], object]) -> float:
    """Return the time of a call, averaged over about 20 ms."""
    timer = timeit.Timer(work, timer=time.process_time)
    once = max(timer.timeit(3) / 3, 1e-7)
    number = max(1, int(0.02 / once))
    return timer.timeit(number) / number * 1e6


def first(work: str) -> float:
    """Return the processor time [ms] of a new Python for it, after it has imported numpy and seoro."""
    program = PROGRAM.format(work=work)
    ran = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    return float(ran.stdout) * 1e3


def works() -> dict[str, list[Callable[[], object]]]:
    """Return the measured functions of each message, by column."""
    ours, theirs = TypeStore.bundled(), get_typestore(Stores.ROS2_JAZZY)
    made: dict[str, list[Callable[[], object]]] = {}
    for title, (name, value) in MESSAGES.items():
        payload = ours.encode(name, value)
        message, other = ours.decode(name, payload), theirs.deserialize_cdr(payload, name)
        assert bytes(theirs.serialize_cdr(other, name)) == payload
        made[title] = [
            lambda name=name, value=value: ours.encode(name, value),  # type: ignore[misc]
            lambda name=name, message=message: ours.encode(name, message),  # type: ignore[misc]
            lambda name=name, payload=payload: ours.decode(name, payload),  # type: ignore[misc]
            lambda name=name, other=other: bytes(theirs.serialize_cdr(other, name)),  # type: ignore[misc]
            lambda name=name, payload=payload: theirs.deserialize_cdr(payload, name),  # type: ignore[misc]
        ]
    return made


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the cost of ROS 2 messages.")
    parser.add_argument("--rounds", type=int, default=11)
    rounds = range(parser.parse_args().rounds)
    measured = works()
    times: dict[tuple[str, int], list[float]] = {}
    firsts: dict[str, list[float]] = {name: [] for name in FIRST}
    for _ in rounds:
        for title, columns in measured.items():
            for column, work in enumerate(columns):
                times.setdefault((title, column), []).append(microseconds(work))
        for name, work_of_first in FIRST.items():
            firsts[name].append(first(work_of_first))
    print(f"{'[us]':18}" + "".join(f"{column:>16}" for column in COLUMNS))
    for title in measured:
        medians = (statistics.median(times[title, column]) for column in range(len(COLUMNS)))
        print(f"{title:18}" + "".join(f"{median:16.1f}" for median in medians))
    print("\nfirst of a process [ms]")
    for name, taken in firsts.items():
        print(f"{name:18}{statistics.median(taken):16.1f}")


if __name__ == "__main__":
    main()
