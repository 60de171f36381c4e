"""CDR compared with two implementations independent of rosbags: mcap-ros2-support and Cyclone DDS."""

import io
import random
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.definitions import PRIMITIVES
from tests.bridges.ros2.interfaces.folders import store_with
from tests.bridges.ros2.interfaces.samples import sample, structures

pytest.importorskip("rosbags", reason="rosbags is not installed (extra `ros2`)")


@pytest.fixture(scope="module")
def store() -> TypeStore:
    return TypeStore.bundled()


def compare_with_mcap(store: TypeStore, values: dict[str, dict[str, Any]]) -> None:
    """Encode values (by type name) and decode payloads of seoro by mcap-ros2-support."""
    reader = pytest.importorskip("mcap.reader", reason="mcap-ros2-support is not installed")
    decoders = pytest.importorskip("mcap_ros2.decoder")
    file = io.BytesIO()
    writer = pytest.importorskip("mcap_ros2.writer").Writer(file)
    for name, value in values.items():
        writer.write_message(name, writer.register_msgdef(short(name), store.schema(name)), value, log_time=1)
    writer.finish()
    file.seek(0)
    factory = decoders.DecoderFactory()
    compared = set()
    for schema, channel, message in reader.make_reader(file).iter_messages():
        name = channel.topic
        payload = store.encode(name, values[name])
        assert message.data == payload, name
        theirs = as_plain(factory.decoder_for("cdr", schema)(payload))
        assert theirs == store.plain(name, store.decode(name, payload)) == values[name], name
        compared.add(name)
    assert compared == set(values)


@pytest.mark.more
def test_all_messages_equal_those_of_mcap(store: TypeStore) -> None:
    names = [name for name in structures(store) if not refers_to_derived(store, name)]
    assert len(names) > 700
    compare_with_mcap(store, {name: sample(store, name, random.Random(name)) for name in names})


def test_random_definitions_equal_those_of_mcap(tmp_path: Path) -> None:
    draw = random.Random(1)
    files = {f"Inner{number}_msg": made_up(draw, []) for number in range(10)}
    files |= {f"Middle{number}_msg": made_up(draw, [f"Inner{number}"]) for number in range(10)}
    files |= {f"Outer{number}_msg": made_up(draw, [f"Middle{number}", f"Inner{number}"]) for number in range(10)}
    store = store_with(tmp_path, **files)
    names = [name for name in store.names() if name.startswith("my_robot/")]
    compare_with_mcap(store, {name: sample(store, name, draw) for name in names})


def made_up(draw: random.Random, named: list[str]) -> str:
    """Return a definition with members of random types, scalar and in arrays of all kinds."""
    names = [*sorted(PRIMITIVES - {"wstring"}), "string<=8", *named * 6]
    ends = ["", "", "[]", "[<=3]", "[1]", "[3]"]
    return "".join(
        f"{draw.choice(names)}{draw.choice(ends)} member_{number}\n" for number in range(draw.randint(0, 5))
    )


def short(name: str) -> str:
    """Return the name in the form of mcap-ros2-support."""
    package, _, base = name.split("/")
    return f"{package}/{base.replace('_', '')}"


def refers_to_derived(store: TypeStore, name: str) -> bool:
    """Return whether a structure has parts of actions, which mcap-ros2-support cannot read."""
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
def test_messages_equal_those_of_cyclone_dds(store: TypeStore, name: str, seed: int) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    from tests.bridges.ros2.interfaces import cyclone

    value = sample(store, name, random.Random(seed))
    payload = store.encode(name, value)
    assert cyclone.encode(name, value) == payload
    assert cyclone.decode(name, payload) == store.plain(name, store.decode(name, payload))
    swapped = cyclone.encode(name, value, big_endian=True)
    assert store.plain(name, store.decode(name, swapped)) == value
