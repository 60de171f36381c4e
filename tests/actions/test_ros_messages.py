"""The methods of the struct `msg_conversion` in `osc.ros`."""

import math

import pytest

from seoro import Orientation3D, Position3D, UsageError
from seoro.actions.ros_messages import MAX_SIZE, get_object_member, read_message, to_pose_3d, to_twist
from seoro.robotics.geometry import OrientationRate3D, TranslationalVelocity3D, Velocity6D
from tests.runtime.conftest import RunText

POSE = "{position: {x: 1.0, y: 2, z: 1.0e-05}, orientation: {x: 0.0, y: 0.0, z: 0.7071, w: 0.7071}}"


async def test_members_and_poses_reach_a_scenario(run_text: RunText) -> None:
    ran = await run_text(
        f"""
import osc.ros

scenario main:
    m: msg_conversion
    text: string = "{{header: {{stamp: 3}}, pose: {{pose: {POSE}}}}}"
    goal: pose_3d = m.to_pose_3d(text)
    do serial:
        log(m.get_object_member(text, "header.stamp"))
        log(goal.position.norm() - goal.position.y > 0.2m ? "far" : "near")
        log(goal.orientation.yaw / 1rad)
"""
    )
    texts = [text for _, text in ran.logs]
    assert texts[:2] == ["3", "far"]
    assert float(texts[2]) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("text", "member", "expected"),
    [
        ("data: hello", "data", "hello"),
        ("data: 1.5\n---", "data", "1.5"),
        ("points: [{x: 1}, {x: 2}]", "points.1.x", "2"),
        ("points: [{x: 1}, {x: true}]", "points.1", '{"x": true}'),
        ('{"x": 1e-05}', "x", "1e-05"),
        ("plain", "", "plain"),
    ],
)
def test_members_are_returned_as_texts(text: str, member: str, expected: str) -> None:
    assert get_object_member(text, member) == expected


@pytest.mark.parametrize(
    ("text", "member", "message"),
    [
        ("a: {b: 1}", "a.c", "unknown member 'c' in 'a.c'"),
        ("a: [1]", "a.1", "unknown index '1' in 'a.1': the list has 1 elements"),
        ("a: 1", "a.b", "the value before it has no members"),
        ("a: [", "a", "cannot read the message"),
        ("a: &x [1]\nb: [*x, *x]", "b", "unsupported alias"),
        ("[" * 30_000, "a", "cannot read the message"),
        ("x" * (MAX_SIZE + 1), "a", "is too long"),
    ],
)
def test_invalid_messages_and_missing_members_are_reported(text: str, member: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        get_object_member(text, member)


@pytest.mark.parametrize("angles", [(0.1, 0.2, 0.3), (-1.0, 1.2, -3.0), (0.0, -1.5, 2.0)])
def test_quaternions_become_roll_pitch_and_yaw(angles: tuple[float, float, float]) -> None:
    roll, pitch, yaw = (angle / 2 for angle in angles)
    # The product of the rotations about z, y and x, in this order; twice as long as it should be.
    x = 2 * (math.cos(yaw) * math.cos(pitch) * math.sin(roll) - math.sin(yaw) * math.sin(pitch) * math.cos(roll))
    y = 2 * (math.cos(yaw) * math.sin(pitch) * math.cos(roll) + math.sin(yaw) * math.cos(pitch) * math.sin(roll))
    z = 2 * (math.sin(yaw) * math.cos(pitch) * math.cos(roll) - math.cos(yaw) * math.sin(pitch) * math.sin(roll))
    w = 2 * (math.cos(yaw) * math.cos(pitch) * math.cos(roll) + math.sin(yaw) * math.sin(pitch) * math.sin(roll))
    text = f'{{"position": {{"x": 1, "y": 2, "z": 3}}, "orientation": {{"x": {x}, "y": {y}, "z": {z}, "w": {w}}}}}'
    pose = to_pose_3d(text)
    assert pose.position == Position3D(1.0, 2.0, 3.0)
    found: Orientation3D = pose.orientation
    assert (found.roll, found.pitch, found.yaw) == pytest.approx(angles)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1", "expected the members `position` and `orientation`"),
        ("position: {x: 1}\norientation: {}", "expected numbers for `x, y, z`"),
        (POSE.replace("0.7071", "0.0"), "its quaternion has no direction"),
    ],
)
def test_invalid_poses_are_reported(text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        to_pose_3d(text)


def test_missing_members_of_a_twist_are_zero() -> None:
    wanted = Velocity6D(TranslationalVelocity3D(0.5), OrientationRate3D(yaw=-1.0))
    assert to_twist({"linear": {"x": 0.5}, "angular": {"z": -1}}) == wanted
    stamped = {"angular": {"z": -1.0}, "linear": {"x": 0.5, "y": 0}}
    assert to_twist({"header": {"stamp": 0}, "twist": stamped}) == wanted
    assert to_twist({}) == Velocity6D()


@pytest.mark.parametrize(
    "message", [{"twist": 3}, {"speed": 1}, {"linear": 1}, {"linear": {"u": 1}}, {"linear": {"x": "fast"}}]
)
def test_invalid_twists_are_refused(message: dict[str, object]) -> None:
    with pytest.raises(UsageError, match="invalid twist"):
        to_twist(message)


@pytest.mark.parametrize("text", ['{"x": 1, "y": {"z": 2, "z": 3}}', "{x: 1, x: 2}"])
def test_repeated_members_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"duplicate key '[xz]'"):
        read_message(text)
