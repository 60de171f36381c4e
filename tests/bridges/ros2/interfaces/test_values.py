"""Conversion of plain values to messages: accepted, missing and invalid members."""

import math
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.ros2.interfaces import InvalidDefinition, InvalidValue, TypeStore, UnknownInterface
from tests.bridges.ros2.interfaces.folders import store_with

np = pytest.importorskip("numpy", reason="numpy is not installed")
pytest.importorskip("rosbags", reason="rosbags is not installed (extra `ros2`)")

PRIMITIVES = [
    "int8",
    "uint8",
    "int16",
    "uint16",
    "int32",
    "uint32",
    "int64",
    "uint64",
    "float32",
    "float64",
    "bool",
]
KINDS = "\n".join(
    [f"{name} an_{name}\n{name}[] some_{name}\n{name}[2] two_{name}" for name in [*PRIMITIVES, "byte", "char"]]
    + ["string text", "string<=3 short", "string[] texts", "string<=3[<=2] few", "geometry_msgs/Point[2] points"]
)
DEFAULTS = "int8 a 5\nstring b x\nfloat32[2] c [1, 2]\nstring[] d [y]\nbool e true\nint8 f\nint8[<=3] g [7]"


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> TypeStore:
    return store_with(
        tmp_path_factory.mktemp("packages"),
        Kinds_msg=KINDS,
        Nothing_msg="int8 A=1",
        Defaults_msg=DEFAULTS,
        Words_msg="int8 from\nint8 class",
        Wide_msg="int8 a\nwstring b",
    )


def refusal(store: TypeStore, name: str, value: Any) -> tuple[str, str, str]:
    with pytest.raises(InvalidValue) as raised:
        store.message(name, value)
    return raised.value.path, str(raised.value), raised.value.help


def test_missing_members_are_zero_empty_or_the_default(store: TypeStore) -> None:
    odometry = store.plain("nav_msgs/Odometry", store.message("nav_msgs/Odometry", {"child_frame_id": "base"}))
    assert odometry["child_frame_id"] == "base"
    assert odometry["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert odometry["pose"]["covariance"] == [0.0] * 36
    assert odometry["pose"]["pose"]["orientation"]["w"] == 1.0  # the default in geometry_msgs
    plain = store.plain("my_robot/Defaults", store.message("my_robot/Defaults", {"f": 1}))
    assert plain == {"a": 5, "b": "x", "c": [1.0, 2.0], "d": ["y"], "e": True, "f": 1, "g": [7]}


def test_members_and_constants_are_attributes(store: TypeStore) -> None:
    status = store.message("action_msgs/GoalStatus", {"status": 4})
    assert status.status == status.STATUS_SUCCEEDED == 4
    assert status.goal_info.stamp.sec == 0
    assert repr(status.goal_info.stamp) == "Time(sec=0, nanosec=0)"


def test_members_named_like_python_keywords_keep_their_names(store: TypeStore) -> None:
    message = store.message("my_robot/Words", {"from": 1, "class": 2})
    assert (message.from_, message.class_) == (1, 2)
    assert store.plain("my_robot/Words", message) == {"from": 1, "class": 2}


def test_a_structure_without_members_is_an_empty_mapping(store: TypeStore) -> None:
    for name in ("my_robot/Nothing", "std_srvs/srv/Trigger_Request", "std_msgs/Empty"):
        message = store.message(name, {})
        assert store.plain(name, message) == {}
        assert store.encode(name, {}) == b"\x00\x01\x00\x00\x00"
        assert store.plain(name, store.decode(name, store.encode(name, message))) == {}
    assert refusal(store, "std_msgs/Empty", {"structure_needs_at_least_one_member": 0})[0] == ""


def test_messages_are_accepted_as_values_and_members(store: TypeStore) -> None:
    point = store.message("geometry_msgs/Point", {"x": 1})
    pose = store.message("geometry_msgs/Pose", {"position": point})
    assert pose.position == point
    assert store.message("geometry_msgs/Pose", pose) == pose
    path, problem, _ = refusal(store, "geometry_msgs/Pose", {"orientation": point})
    assert path == "orientation"
    assert problem.endswith("`: expected a geometry_msgs/msg/Quaternion, got a geometry_msgs/msg/Point")


def test_messages_are_equal_if_their_members_are(store: TypeStore) -> None:
    value = {"header": {"frame_id": "laser"}, "ranges": [1.0, 2.0]}
    scan = store.message("sensor_msgs/LaserScan", value)
    assert scan == store.decode("sensor_msgs/LaserScan", store.encode("sensor_msgs/LaserScan", value))
    assert scan == TypeStore.bundled().message("sensor_msgs/LaserScan", value)
    assert scan != store.message("sensor_msgs/LaserScan", value | {"ranges": [1.0, 3.0]})
    assert scan != store.message("sensor_msgs/LaserScan", value | {"ranges": [1.0]})
    point, vector = store.message("geometry_msgs/Point", {}), store.message("geometry_msgs/Vector3", {})
    assert point != vector
    assert point != (0.0, 0.0, 0.0)
    with pytest.raises(TypeError, match="unhashable"):
        hash(point)


def test_members_of_messages_are_checked(store: TypeStore) -> None:
    broken = store.message("geometry_msgs/Point", {})._replace(y="far")
    assert refusal(store, "geometry_msgs/Point", broken)[0] == "y"


def test_a_message_is_refused_as_a_list(store: TypeStore) -> None:
    point = store.message("geometry_msgs/Point", {})
    assert refusal(store, "my_robot/Kinds", {"some_float64": point})[0] == "some_float64"


@pytest.mark.parametrize(
    ("member", "value", "expected"),
    [
        ("an_float64", 3, 3.0),
        ("an_float64", np.float32(0.5), 0.5),
        ("an_float64", math.inf, math.inf),
        ("an_float32", np.int8(3), 3.0),
        ("an_int8", np.int64(-128), -128),
        ("an_bool", np.True_, True),
        ("an_byte", 200, 200),
        ("an_byte", b"\xc8", 200),
        ("an_char", 255, 255),
        ("text", "grün", "grün"),
        ("short", "abc", "abc"),
        ("some_uint8", b"\x01\x02", [1, 2]),
        ("some_byte", bytearray(b"\xff"), [255]),
        ("some_int16", (1, -2), [1, -2]),
        ("some_float32", [1, 0.5, math.inf], [1.0, 0.5, math.inf]),
        ("some_float32", np.array([1, 2]), [1.0, 2.0]),
        ("some_float64", np.arange(6.0)[::2], [0.0, 2.0, 4.0]),
        ("some_int8", np.array([-128, 127], np.int64), [-128, 127]),
        ("some_int32", np.array([1], ">i4"), [1]),
        ("some_bool", [True, False], [True, False]),
        ("some_bool", np.array([True]), [True]),
        ("some_uint64", [2**64 - 1], [2**64 - 1]),
        ("two_float64", np.zeros(2, np.float32), [0.0, 0.0]),
        ("texts", ["a", "bc"], ["a", "bc"]),
        ("few", ["abc"], ["abc"]),
        ("some_int8", np.array([], np.uint64), []),
    ],
)
def test_convertible_values_are_accepted(store: TypeStore, member: str, value: Any, expected: object) -> None:
    payload = store.encode("my_robot/Kinds", {member: value})
    assert store.plain("my_robot/Kinds", store.decode("my_robot/Kinds", payload))[member] == expected


@pytest.mark.parametrize(
    ("value", "path", "problem"),
    [
        ({"an_int8": 128}, "an_int8", "expected a whole number from -128 to 127 (int8), got 128"),
        ({"an_uint8": -1}, "an_uint8", "from 0 to 255 (uint8), got -1"),
        ({"an_int64": 2**63}, "an_int64", f"got {2**63}"),
        ({"an_int64": 10**5000}, "an_int64", "got a huge number"),
        ({"an_int32": 1.0}, "an_int32", "expected a whole number (int32), got 1.0"),
        ({"an_int32": True}, "an_int32", "expected a whole number (int32), got true"),
        ({"an_int32": "1"}, "an_int32", "got the string '1'"),
        ({"an_int32": None}, "an_int32", "got nothing"),
        ({"an_byte": b"ab"}, "an_byte", "expected a whole number (byte), got 2 bytes"),
        ({"an_float64": "1.5"}, "an_float64", "expected a number, got the string '1.5'"),
        ({"an_float64": False}, "an_float64", "got false"),
        ({"an_float64": 10**400}, "an_float64", "got a huge number"),
        ({"an_float32": 1e39}, "an_float32", "expected a number up to 3.4028"),
        ({"an_bool": 1}, "an_bool", "expected true or false, got 1"),
        ({"text": 5}, "text", "expected a string, got 5"),
        ({"text": "a\0b"}, "text", "without the character NUL"),
        ({"text": "\ud800"}, "text", "expected a valid Unicode string"),
        ({"short": "abcd"}, "short", "expected a string of at most 3 bytes, got the string 'abcd'"),
        ({"short": "grü"}, "short", "at most 3 bytes"),
        ({"some_int8": [1, 2, 300]}, "some_int8[2]", "got 300"),
        ({"some_int8": 5}, "some_int8", "expected a list (int8[]), got 5"),
        ({"some_int8": "123"}, "some_int8", "expected a list"),
        ({"some_int8": b"12"}, "some_int8", "got 2 bytes"),
        ({"some_float32": [0.5, [1]]}, "some_float32[1]", "got a list of 1"),
        ({"some_float32": np.array([1e300])}, "some_float32", "expected numbers within the range of float32"),
        ({"some_float32": np.zeros((2, 2))}, "some_float32", "expected one dimension (float32[])"),
        ({"some_int8": np.array([1.0])}, "some_int8", "expected an array of int8, got an array of float64"),
        ({"some_uint8": np.array([256])}, "some_uint8", "expected numbers from 0 to 255"),
        ({"some_bool": np.array([1])}, "some_bool", "expected an array of bool"),
        ({"some_float64": np.array(["a"])}, "some_float64", "expected an array of float64"),
        ({"two_int8": [1]}, "two_int8", "expected 2 elements (int8[2]), got 1"),
        ({"two_int8": np.zeros(3, np.int8)}, "two_int8", "expected 2 elements (int8[2]), got 3"),
        ({"two_uint8": b"abc"}, "two_uint8", "expected 2 elements (uint8[2]), got 3"),
        ({"few": ["a", "b", "c"]}, "few", "expected at most 2 elements (string<=3[<=2]), got 3"),
        ({"few": ["a", "long"]}, "few[1]", "at most 3 bytes"),
        ({"texts": "abc"}, "texts", "expected a list (string[]), got the string 'abc'"),
        ({"points": [{}, {"x": "far"}]}, "points[1].x", "expected a number, got the string 'far'"),
        ({"points": [{}]}, "points", "expected 2 elements"),
        ({"points": {"x": 1}}, "points", "got a mapping with 1 entries"),
        ({"points": [{}, 5]}, "points[1]", "expected a geometry_msgs/msg/Point, got 5"),
    ],
)
def test_invalid_values_are_refused_with_their_path(
    store: TypeStore, value: dict[str, Any], path: str, problem: str
) -> None:
    found, message, _ = refusal(store, "my_robot/Kinds", value)
    assert found == path
    assert message.startswith(f"my_robot/msg/Kinds, `{path}`: ")
    assert problem in message


def test_unknown_members_are_refused_with_similar_ones(store: TypeStore) -> None:
    path, problem, help_ = refusal(store, "geometry_msgs/PoseStamped", {"pose": {"positon": {}}})
    assert path == "pose"
    assert problem.endswith("`pose`: unknown member `positon` of geometry_msgs/msg/Pose")
    assert help_ == "did you mean `position`?"
    _, _, help_ = refusal(store, "geometry_msgs/Point", {"where": 1})
    assert help_ == "its members are `x`, `y`, `z`"
    _, _, help_ = refusal(store, "std_msgs/Empty", {"data": 1})
    assert help_ == "it has no members"


def test_refusals_of_values_suggest_a_fix(store: TypeStore) -> None:
    assert "in quotes" in refusal(store, "std_msgs/String", {"data": 5})[2]
    assert refusal(store, "geometry_msgs/Point", {"x": "1.5"})[2] == "write it without quotes"
    assert refusal(store, "std_msgs/Int8", {"data": "1"})[2] == "write it without quotes"
    assert refusal(store, "std_msgs/Int8", {"data": "one"})[2] == ""
    help_ = refusal(store, "geometry_msgs/Pose", {"position": [1, 2, 3]})[2]
    assert help_ == "write a mapping; its members are `x`, `y`, `z`"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("std_srvs/srv/SetBool", "`std_srvs/srv/SetBool` is a service, not a message"),
        ("nav2_msgs/Spin", "`nav2_msgs/action/Spin` is an action, not a message"),
        ("nav2_msgs/action/Spin_SendGoal", "`nav2_msgs/action/Spin_SendGoal` is a service, not a message"),
    ],
)
def test_services_and_actions_are_refused_as_messages(store: TypeStore, name: str, problem: str) -> None:
    with pytest.raises(UnknownInterface) as raised:
        store.encode(name, {})
    assert str(raised.value) == problem
    with pytest.raises(UnknownInterface):
        store.decode(name, b"")
    assert "`Spin_Goal`" in raised.value.help or "`SetBool_Request`" in raised.value.help


def test_wide_strings_are_refused_but_have_a_hash(store: TypeStore, tmp_path: Path) -> None:
    assert store.type_hash("my_robot/Wide").startswith("RIHS01_")
    with pytest.raises(InvalidDefinition, match="my_robot/msg/Wide, `b`: unsupported type `wstring`") as raised:
        store.encode("my_robot/Wide", {"a": 1})
    assert "use `string`" in raised.value.help


def test_plain_refuses_a_message_of_another_type(store: TypeStore) -> None:
    message = store.message("std_msgs/String", {})
    with pytest.raises(InvalidValue, match=r"expected a std_msgs/msg/Bool, got a std_msgs/msg/String"):
        store.plain("std_msgs/Bool", message)


def test_nan_and_infinity_are_preserved(store: TypeStore) -> None:
    scan = store.message("sensor_msgs/LaserScan", {"ranges": [math.nan, math.inf]})
    ranges = store.plain("sensor_msgs/LaserScan", scan)["ranges"]
    assert math.isnan(ranges[0])
    assert ranges[1] == math.inf
