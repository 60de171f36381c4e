"""CDR: encoding, byte orders, and invalid payloads."""

import struct
from typing import Any

import pytest

from seoro.bridges.ros2.interfaces import InvalidPayload, InvalidValue, TypeStore
from tests.bridges.ros2.interfaces.folders import store_with

np = pytest.importorskip("numpy", reason="numpy is not installed")
pytest.importorskip("rosbags", reason="rosbags is not installed (extra `ros2`)")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> TypeStore:
    return store_with(
        tmp_path_factory.mktemp("packages"),
        Mixed_msg="uint8 a\nfloat64 b\nstring c\nuint16[3] d\nint64[] e\nstring[] f\nbyte g",
    )


def test_messages_are_encoded_as_cdr(store: TypeStore) -> None:
    assert store.encode("std_msgs/String", {"data": "hi"}) == b"\x00\x01\x00\x00" + b"\x03\x00\x00\x00hi\x00"
    twist = store.encode("geometry_msgs/Twist", {"linear": {"x": 0.5}, "angular": {"z": -1}})
    assert twist == b"\x00\x01\x00\x00" + struct.pack("<6d", 0.5, 0, 0, 0, 0, -1)


def test_alignment_counts_from_the_end_of_the_header(store: TypeStore) -> None:
    payload = store.encode(
        "my_robot/Mixed", {"a": 7, "b": 1.5, "c": "xyz", "d": [1, 2, 3], "e": [-1], "f": ["p", ""], "g": 255}
    )
    expected = struct.pack("<B7xd", 7, 1.5) + struct.pack("<I4s3H", 4, b"xyz\0", 1, 2, 3)
    expected += b"\0" * (-len(expected) % 4) + struct.pack("<I", 1)
    expected += b"\0" * (-len(expected) % 8) + struct.pack("<q", -1)
    expected += struct.pack("<II2s2xI1sB", 2, 2, b"p\0", 1, b"\0", 255)
    assert payload == b"\x00\x01\x00\x00" + expected


def test_big_endian_messages_are_decoded(store: TypeStore) -> None:
    payload = b"\x00\x00\x00\x00" + struct.pack(">iII4s", 5, 6, 4, b"map\0")
    header = store.decode("std_msgs/Header", payload)
    assert store.plain("std_msgs/Header", header) == {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "map"}
    array = b"\x00\x00\x00\x00" + struct.pack(">IIIf", 0, 0, 1, 1.5)
    assert store.decode("std_msgs/Float32MultiArray", array).data.tolist() == [1.5]


def test_padding_at_the_end_is_ignored(store: TypeStore) -> None:
    payload = store.encode("std_msgs/String", {"data": "hi"})
    assert store.decode("std_msgs/String", payload + b"\0" * 3).data == "hi"


def test_arrays_are_views_of_the_payload(store: TypeStore) -> None:
    image = store.decode("sensor_msgs/Image", store.encode("sensor_msgs/Image", {"data": b"\x05" * 100}))
    assert image.data.dtype == np.uint8
    assert not image.data.flags.writeable
    assert not image.data.flags.owndata


@pytest.mark.parametrize(
    ("name", "payload", "problem"),
    [
        ("std_msgs/String", b"", "truncated message of 0 bytes; expected a header of 4 bytes"),
        ("std_msgs/String", b"\x00\x01", "truncated message of 2 bytes"),
        ("std_msgs/String", b"hello world", "the payload begins with 68 65 6c 6c; expected plain CDR"),
        ("std_msgs/String", b"\x00\x07\x00\x00\x00", "(CDR2)"),
        ("std_msgs/String", b"\x00\x03\x00\x00\x00", "(PL_CDR)"),
        ("std_msgs/String", b"\x00\x01\x00\x00\xff\xff\xff\xff", "invalid or truncated message"),
        ("std_msgs/String", b"\x00\x01\x00\x00\x02\x00\x00\x00a!", "invalid or truncated message"),
        ("std_msgs/String", b"\x00\x01\x00\x00\x02\x00\x00\x00\xff\x00", "invalid or truncated message"),
        ("std_msgs/String", b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00xxxx", "the message ends after 10 of 14 bytes"),
        ("geometry_msgs/Twist", b"\x00\x01\x00\x00" + b"\x00" * 47, "truncated message"),
        ("sensor_msgs/Image", b"\x00\x01\x00\x00" + b"\x00" * 10, "truncated message"),
        (
            "nav_msgs/Path",
            b"\x00\x01\x00\x00" + b"\x00" * 16 + b"\xff\xff\xff\x7f",
            "invalid or truncated message",
        ),
    ],
)
def test_invalid_payloads_are_refused(store: TypeStore, name: str, payload: bytes, problem: str) -> None:
    with pytest.raises(InvalidPayload) as raised:
        store.decode(name, payload)
    assert str(raised.value).startswith(store.canonical(name))
    assert problem in str(raised.value)


def test_truncated_messages_are_refused(store: TypeStore) -> None:
    value: dict[str, Any] = {"a": 7, "b": 1.5, "c": "xyz", "d": [1, 2, 3], "e": [-1], "f": ["p", ""], "g": 255}
    payload = store.encode("my_robot/Mixed", value)
    for length in range(len(payload)):
        with pytest.raises(InvalidPayload):
            store.decode("my_robot/Mixed", payload[:length])


def test_messages_have_a_size_limit(store: TypeStore, monkeypatch: pytest.MonkeyPatch) -> None:
    payload = store.encode("sensor_msgs/Image", {"data": bytes(2000)})
    monkeypatch.setattr("seoro.bridges.ros2.interfaces.codec.MAX_PAYLOAD", 1000)
    with pytest.raises(InvalidValue, match="exceed the limit of 1000"):
        store.encode("sensor_msgs/Image", {"data": bytes(2000)})
    with pytest.raises(InvalidPayload, match="exceed the limit of 1000"):
        store.decode("sensor_msgs/Image", payload)


def test_all_interfaces_are_equal_after_encoding_and_decoding() -> None:
    store = TypeStore.bundled()
    for interface in store.names():
        kind = interface.split("/")[1]
        for suffix in {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_FeedbackMessage")}[
            kind
        ]:
            name = interface + suffix
            if name == "example_interfaces/msg/WString":  # of `wstring`
                continue
            payload = store.encode(name, {})
            assert store.encode(name, store.decode(name, payload)) == payload, name
