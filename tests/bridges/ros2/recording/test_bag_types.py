"""Definitions of types that only a bag has."""

from __future__ import annotations

from pathlib import Path

import pytest

import seoro
from seoro.bridges.ros2.interfaces import InvalidDefinition, TypeStore, UnknownInterface
from seoro.bridges.ros2.recording.bag_types import recorded_types
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.reader import open_bag
from seoro.bridges.ros2.recording.writer import write_bag
from tests.bridges.ros2.interfaces.folders import make_folder
from tests.bridges.ros2.recording.bags import START, TYPES

pytestmark = pytest.mark.anyio

STATUS, BATTERY = "my_robot/msg/Status", "sensor_msgs/msg/BatteryState"
RULER = f"int8 a\n{'=' * 80}\n"
SCENARIO = """import osc.helpers
import osc.ros
scenario field:
    robot: differential_drive_robot
    do check_data("/status", "{}", "7", member_name: "wheel.slips", fail_if_bad_comparison: true)
"""


def robot_types(folder: Path) -> TypeStore:
    """Return the definitions of a robot: a package of its own, and another one of a message that seoro knows."""
    make_folder(folder, Status_msg="std_msgs/Header header\nWheel wheel\n", Wheel_msg="int32 slips\nstring name\n")
    other = folder / "sensor_msgs" / "msg" / "BatteryState.msg"
    other.parent.mkdir(parents=True)
    other.write_text("float64 percentage\nstring maker\n")
    return TypeStore.bundled().add_folder(folder)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("name", [STATUS, "my_robot.msg.Status"])
async def test_messages_of_unknown_types_are_read_by_the_definition_in_the_bag(
    tmp_path: Path, storage: str, name: str
) -> None:
    types = robot_types(tmp_path / "share")
    topic = BagTopic("/status", STATUS, types.type_hash(STATUS))
    async with write_bag(tmp_path / "bag", storage=storage) as writer:
        writer.add_topic(topic, types.schema(STATUS))
        writer.write("/status", types.encode(STATUS, {"wheel": {"slips": 7}}), START)
    file = tmp_path / "field.osc"
    file.write_text(SCENARIO.format(name))
    async with seoro.start(seoro.load(file), bag=tmp_path / "bag") as run:
        verdict = await run.result()
    assert verdict.passed, verdict


async def test_other_definitions_of_known_types_are_those_of_the_bag(tmp_path: Path) -> None:
    types = robot_types(tmp_path / "share")
    async with write_bag(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/battery", BATTERY, types.type_hash(BATTERY)), types.schema(BATTERY))
        writer.write("/battery", b"", START)
    [topic] = open_bag(tmp_path / "bag").topics.values()
    found = recorded_types(topic, TYPES, "the bag")
    assert found.schema(BATTERY) == "float64 percentage\nstring maker\n"
    payload = types.encode(BATTERY, {"percentage": 0.5, "maker": "us"})
    assert found.decode(BATTERY, payload).maker == "us"


def test_known_definitions_are_kept() -> None:
    schema, hash_ = TYPES.schema(BATTERY), TYPES.type_hash(BATTERY)
    for topic in (
        BagTopic("/battery", BATTERY, hash_, definition=schema),
        BagTopic("/battery", BATTERY, definition=schema),
        BagTopic("/battery", BATTERY),
    ):
        assert recorded_types(topic, TYPES, "the bag") is TYPES


@pytest.mark.parametrize(
    ("topic", "error", "reason"),
    [
        (BagTopic("/s", STATUS), UnknownInterface, f"the bag lacks the definition of {STATUS}"),
        (BagTopic("/b", BATTERY, "RIHS01_0"), UnknownInterface, f"the bag lacks the definition of {BATTERY}"),
        (BagTopic("/s", STATUS, "RIHS01_0", definition="int8 a\n"), UnknownInterface, "lacks the definition"),
        (BagTopic("/s", STATUS, definition="nonsense\n"), InvalidDefinition, "the bag"),
        (
            BagTopic("/s", STATUS, definition=f"int8 a\n{'=' * 80}\nint8 b\n"),
            InvalidDefinition,
            "expected `MSG: NAME`",
        ),
        (BagTopic("/s", STATUS, definition=f"int8 a\n{'=' * 80}\nMSG: a/srv/B\n"), InvalidDefinition, "`a/srv/B`"),
    ],
)
def test_missing_and_invalid_definitions_are_refused(topic: BagTopic, error: type[Exception], reason: str) -> None:
    with pytest.raises(error, match=reason):
        recorded_types(topic, TYPES, "the bag")
