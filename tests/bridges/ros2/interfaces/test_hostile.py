"""Random texts and payloads are decoded, or raise the specified errors."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges.ros2.interfaces import InvalidDefinition, InvalidPayload, TypeStore
from seoro.bridges.ros2.interfaces.syntax import read_interface
from seoro.bridges.ros2.interfaces.text import definition
from tests.bridges.ros2.interfaces.samples import sample, structures

WORDS = [
    "int8",
    "string",
    "float32",
    "Pose",
    "bool",
    "std_msgs/Header",
    "name",
    "X",
    "\n",
    " ",
    "\t",
    "---\n",
    "#",
    "=",
]
SIGNS = ["[", "]", "<=", "3", "0", "-", "1.5", "true", '"', "'", "\\", ",", "é", "\0", "\r", "\u2028"]


@given(st.lists(st.sampled_from(WORDS + SIGNS), max_size=40).map("".join))
def test_random_definitions_are_read_or_refused(text: str) -> None:
    try:
        (read,) = read_interface("my_robot/msg/Thing", text, "Thing.msg")
    except InvalidDefinition:
        return
    (again,) = read_interface("my_robot/msg/Thing", definition(read), "again")
    assert again == read


def test_random_payloads_are_decoded_or_refused() -> None:
    pytest.importorskip("rosbags", reason="rosbags is not installed (extra `ros2`)")
    store = TypeStore.bundled()
    draw = random.Random(1)
    names = draw.sample(structures(store), 40)
    read = 0
    for _ in range(200):
        name = draw.choice(names)
        payload = bytearray(store.encode(name, sample(store, name, draw)))
        for _ in range(10):
            broken = bytearray(payload)
            for _ in range(draw.randint(0, 4)):
                broken[draw.randrange(1, len(broken))] = draw.choice([0, 1, 127, 128, 255])
            del broken[draw.choice([len(broken), draw.randrange(len(broken))]) :]
            try:
                store.plain(name, store.decode(name, bytes(broken)))
                read += 1
            except InvalidPayload:
                pass
    assert read > 100
