"""Reading .msg, .srv and .action files."""

from typing import Any

import pytest

from seoro.bridges.ros2.interfaces import InvalidDefinition
from seoro.bridges.ros2.interfaces.definitions import Array, Constant, Field, Named, Scalar, Sequence, Structure
from seoro.bridges.ros2.interfaces.syntax import read_interface


def read(text: str, name: str = "my_robot/msg/Thing") -> Structure:
    (structure,) = read_interface(name, text, "Thing.msg")
    return structure


def refusal(text: str, name: str = "my_robot/msg/Thing") -> str:
    with pytest.raises(InvalidDefinition) as raised:
        read_interface(name, text, "Thing.msg")
    return f"{raised.value}\n{raised.value.help}"


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("float64", Scalar("float64")),
        ("string", Scalar("string")),
        ("string<=10", Scalar("string", 10)),
        ("Other", Named("my_robot/msg/Other")),
        ("geometry_msgs/Point", Named("geometry_msgs/msg/Point")),
        ("geometry_msgs/msg/Point", Named("geometry_msgs/msg/Point")),
        ("int8[]", Sequence(Scalar("int8"))),
        ("int8[<=4]", Sequence(Scalar("int8"), 4)),
        ("int8[4]", Array(Scalar("int8"), 4)),
        ("string<=5[<=10]", Sequence(Scalar("string", 5), 10)),
        ("string<=5[2]", Array(Scalar("string", 5), 2)),
        ("geometry_msgs/Point[]", Sequence(Named("geometry_msgs/msg/Point"))),
    ],
)
def test_member_types_are_read(written: str, expected: object) -> None:
    assert read(f"{written} member").fields == (Field("member", expected),)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("line", "default"),
    [
        ("int32 a -7", -7),
        ("uint8 a 0xff", 255),
        ("float32 a 1e-3", 0.001),
        ("float64 a .5", 0.5),
        ("bool a true", True),
        ("bool a 0", False),
        ("string a", None),
        ('string a "two words"', "two words"),
        ("string a 'it''s'".replace("''", r"\'"), "it's"),
        ("string a bare words", "bare words"),
        ('string a ""', ""),
        ("int32[] a [1, -2,3]", (1, -2, 3)),
        ("int32[] a []", ()),
        ("float64[2] a [1, 2.5]", (1.0, 2.5)),
        ("string[] a [\"x, y\", 'z', w]", ("x, y", "z", "w")),
    ],
)
def test_default_values_are_read(line: str, default: Any) -> None:
    assert read(line).fields[0].default == default


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("uint8 OK=0", 0),
        ("int32 LOW = -5", -5),
        ("float64 PI=3.25", 3.25),
        ("string NAME=some words", "some words"),
        ('string NAME="a=b"', "a=b"),
        ("string EMPTY=", ""),
        ("bool YES=True", True),
    ],
)
def test_constants_are_read(line: str, value: object) -> None:
    structure = read(line)
    assert structure.fields == ()
    assert structure.constants[0].value == value


def test_comments_and_blanks_are_ignored() -> None:
    text = "# all about it\r\n\r\n  # more\r\nint8\t a\t 3 # [m]\r\n   string  b\r\nint8 C=1# one\r\n"
    structure = read(text)
    assert structure.fields == (Field("a", Scalar("int8"), 3), Field("b", Scalar("string")))
    assert structure.constants == (Constant("C", Scalar("int8"), 1),)


def test_a_comment_may_start_within_quotes_as_in_ros() -> None:
    assert read('string a "before # after').fields[0].default == '"before'


def test_services_and_actions_are_split_into_parts() -> None:
    request, response = read_interface("my_robot/srv/Grip", "float64 force\n---\nbool done\n", "Grip.srv")
    assert (request.name, response.name) == ("my_robot/srv/Grip_Request", "my_robot/srv/Grip_Response")
    assert response.fields == (Field("done", Scalar("bool")),)
    goal, result, feedback = read_interface("my_robot/action/Dock", "---\n---\nfloat64 left\n", "Dock.action")
    assert goal.fields == result.fields == ()
    assert feedback.name == "my_robot/action/Dock_Feedback"
    assert feedback.fields[0].line == 3


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("int32", "Thing.msg:1: `int32` is a type without a name"),
        ("int32 a\nint33 b", "Thing.msg:2: invalid type `int33`"),
        ("time stamp", "ROS 2 has `builtin_interfaces/Time`"),
        ("Header[ header", "invalid type `Header[`"),
        ("int32[0] a", "expected 1 to"),
        ("int32[<=0] a", "expected 1 to 4294967295"),
        ("int32[<=] a", "invalid size"),
        ("int32[3 a", "invalid type `int32[3`"),
        ("int32[3][] a", "invalid type `int32[3][]`"),
        ("int32[٣] a", "invalid size"),
        ("int32[99999999999999999999] a", "invalid size"),
        ("stringy<=3 a", "only `string` has one"),
        ("geometry_msgs/Point[5000] a", "expected 1 to 4096"),
        ("int32<=3 a", "only `string` has one"),
        ("Point<=3 a", "only `string` has one"),
        ("string<=0 a", "expected 1 to"),
        ("int32 Speed", "`Speed` is an invalid field name"),
        ("int32 a__b", "`a__b` is an invalid field name"),
        ("int32 a;import", "`a;import` is an invalid field name"),
        ("int32 max=3", "`max` is an invalid constant name"),
        ("Point P=3", "constants are numbers, bool or string"),
        ("int8 LIMIT=300", "300 is outside the range of int8, -128 to 127"),
        ("int8 LIMIT=", "constant `LIMIT` has no value"),
        ("int8 a 1.5", "default of `a`: `1.5` is not a valid int8"),
        ("float32 a fast", "`fast` is not a valid float32"),
        ("bool a yes", "`yes` is not a bool; expected true or false"),
        ("Point a 3", "cannot have a default"),
        ("int8[2] a [1]", "expected 2 elements (int8[2]), got 1"),
        ("int8[<=2] a [1, 2, 3]", "expected at most 2 elements (int8[<=2]), got 3"),
        ("int8[] a 1", "is not a list"),
        ("int8[] a [1,,2]", "an empty element"),
        ("int8[] a [1,2,]", "an empty element"),
        ("int8[] a [,]", "an empty element"),
        ('string[] a ["a" b", c]', 'has a " within'),
        (f"int8 {'A' * 5000}a=1", "is an invalid constant name"),
        (f"string[] a [{' ' * 100_000}x, {chr(34) * 99_999}]", 'has a " within'),
        ('string a "x"y"', 'has a " within'),
        ("string<=2 a abc", "longer than string<=2"),
        ("int8 a\nint8 b\nfloat32 a", "Thing.msg:3: duplicate name `a` (first in line 1)"),
        ("int8 a\n---\nint8 b", "expected 1 part of a .msg file, got 2"),
        ("Bad_Name/Point a", "`Bad_Name` is an invalid package name"),
        ("x" * 1_000_001, "exceed the limit of 1000000"),
    ],
)
def test_invalid_definitions_are_reported_with_the_line(text: str, problem: str) -> None:
    assert problem in refusal(text)


def test_a_service_without_a_separator_is_refused() -> None:
    message = refusal("int8 a", "my_robot/srv/Grip")
    assert "expected 2 parts of a .srv file, got 1" in message
    assert "lines of `---`" in message
