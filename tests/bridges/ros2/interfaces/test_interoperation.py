"""CDR against two implementations that share nothing with rosbags: mcap-ros2-support and Cyclone DDS."""

import io
import random
from typing import Any

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from tests.bridges.ros2.interfaces.samples import sample, structures

pytest.importorskip("rosbags", reason="rosbags is not installed (extra `ros2`)")


@pytest.fixture(scope="module")
def store() -> TypeStore:
    return TypeStore.bundled()


def test_all_messages_are_the_same_to_mcap(store: TypeStore) -> None:
    reader = pytest.importorskip("mcap.reader", reason="mcap-ros2-support is not installed")
    decoders = pytest.importorskip("mcap_ros2.decoder")
    writers = pytest.importorskip("mcap_ros2.writer")
    file = io.BytesIO()
    writer = writers.Writer(file)
    names = [name for name in structures(store) if not refers_to_derived(store, name)]
    values = {name: sample(store, name, random.Random(name)) for name in names}
    for name, value in values.items():
        writer.write_message(name, writer.register_msgdef(short(name), store.schema(name)), value, log_time=1)
    writer.finish()
    file.seek(0)
    factory = decoders.DecoderFactory()
    compared = 0
    for schema, channel, message in reader.make_reader(file).iter_messages():
        payload = store.encode(channel.topic, values[channel.topic])
        assert message.data == payload, channel.topic
        theirs = as_plain(factory.decoder_for("cdr", schema)(payload))
        ours = store.plain(channel.topic, store.decode(channel.topic, payload))
        assert theirs == ours == values[channel.topic], channel.topic
        compared += 1
    assert compared == len(names) > 600


def short(name: str) -> str:
    """A name that mcap-ros2-support takes."""
    package, _, base = name.split("/")
    return f"{package}/{base.replace('_', '')}"


def refers_to_derived(store: TypeStore, name: str) -> bool:
    """Whether it has parts of actions, whose names mcap-ros2-support does not read."""
    return "/action/" in store.schema(name)


def as_plain(message: Any) -> Any:
    if hasattr(message, "__slots__"):
        return {name: as_plain(getattr(message, name)) for name in message.__slots__}
    return [as_plain(item) for item in message] if isinstance(message, list | bytes) else message


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "name",
    [
        "geometry_msgs/msg/Twist",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs/msg/JointState",
        "sensor_msgs/msg/CompressedImage",
        "action_msgs/msg/GoalStatusArray",
        "tf2_msgs/msg/TFMessage",
        "diagnostic_msgs/msg/DiagnosticArray",
        "std_msgs/msg/UInt64MultiArray",
    ],
)
def test_messages_are_the_same_to_cyclone_dds(store: TypeStore, name: str, seed: int) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    from tests.bridges.ros2.interfaces import cyclone

    value = sample(store, name, random.Random(seed))
    payload = store.encode(name, value)
    assert cyclone.encode(name, value) == payload
    assert cyclone.decode(name, payload) == store.plain(name, store.decode(name, payload))
    swapped = cyclone.encode(name, value, big_endian=True)
    assert store.plain(name, store.decode(name, swapped)) == value
