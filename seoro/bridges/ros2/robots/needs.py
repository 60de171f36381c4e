"""Topics and actions that a bridge needs of a robot, by its profile."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from seoro.bridges.ros2.robots.parts import PARTS, Part
from seoro.bridges.ros2.robots.profile import Profile


@dataclass(frozen=True)
class Need:
    """Topic or action that a bridge needs of a robot.

    Attributes:
        part: Its part.
        key: Key of its name in the profile.
        owner: Program of the robot that has it, in words.
        is_fatal: Whether scenarios with the robot fail without it; otherwise some may pass.
        is_stream: Whether its messages arrive all the time.
        name: Name in the profile.
    """

    part: Part
    key: str
    owner: str
    is_fatal: bool
    is_stream: bool
    name: str


_NEEDS: Final = (
    # part, key, owner, is_fatal, is_stream
    ("cmd_vel", "base.cmd_vel", "the driver of the base", True, False),
    ("odometry", "base.odometry", "the odometry of the base", True, True),
    ("initial_pose", "base.initial_pose", "the localisation", False, False),
    ("pose", "base.pose", "the localisation", False, False),
    ("navigate_to_pose", "base.navigate_to_pose", "the navigation", False, False),
    ("joint_states", "arm.joint_states", "the publisher of joint states", True, True),
    ("trajectory", "arm.trajectory", "the controller of the arm", True, False),
    ("move_group", "arm.move_group.action", "MoveIt", True, False),
    ("gripper", "arm.gripper.action", "the controller of the gripper", True, False),
    ("tf", "tf", "the publisher of transforms", False, True),
)


def needs_of(profile: Profile) -> Iterator[Need]:
    """Yield the needs of a robot with a profile."""
    for part, key, owner, is_fatal, is_stream in _NEEDS:
        name = _name_at(profile, key)
        if name is not None:
            yield Need(PARTS[part], key, owner, is_fatal, is_stream, name)
    if "battery" in profile.model_fields_set:
        yield Need(PARTS["battery"], "battery", "the driver of the battery", False, False, profile.battery)
    for sensor, topic in profile.sensors.force.items():
        yield Need(PARTS["force"], f"sensors.force.{sensor}", f"the sensor '{sensor}'", False, True, topic)
    for sensor, detector in profile.sensors.sight.items():
        key, owner = f"sensors.sight.{sensor}.topic", f"the detector '{sensor}'"
        yield Need(PARTS["sight"], key, owner, False, False, detector.topic)


def _name_at(profile: Profile, key: str) -> str | None:
    """Return the name at a key of a profile; None if the robot lacks the part."""
    found: object = profile
    for field in key.split("."):
        found = getattr(found, field)
        if found is None:
            return None
    return str(found)
