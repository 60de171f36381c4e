"""Profiles: parts of a family of robots, and names of their topics, services, actions and frames.

Names without a leading slash are below the namespace of the robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, ClassVar, Self

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from seoro.bridges.ros2.wire.names import InvalidName, resolve
from seoro.errors import UsageError
from seoro.files.key_rules import KeyCount, KeyRules, WithKeyRules
from seoro.files.yaml_lines import FileError, Lines, read_text, read_yaml, validate


def _checked_name(name: str) -> str:
    if name.startswith("~"):
        raise ValueError("private names are unsupported: write out the topic, service or action of the robot")
    try:
        resolve(name, "/", "robot")
    except InvalidName as error:
        raise ValueError(str(error)) from error
    return name


def _nonzero(value: float) -> float:
    if value == 0.0:
        raise ValueError("Input should not be 0")
    return value


Name = Annotated[str, AfterValidator(_checked_name)]
Frame = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_/]{0,200}$")]
Given = Annotated[str, Field(min_length=1)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0.0)]


class _Part(WithKeyRules):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Limits(_Part):
    """Speed limits of velocity commands: linear in both directions [m/s], and angular [rad/s]."""

    linear: Positive
    angular: Positive


class Base(_Part):
    """Driving base.

    Args:
        limits: Limits of velocity commands; the navigation of the robot has its own.
        cmd_vel: Topic of velocity commands, `Twist` or `TwistStamped` as its subscriptions expect.
        odometry: Topic of `nav_msgs/Odometry`.
        map_frame: Frame of goal poses.
        initial_pose: Topic of initial poses.
        pose: Topic of estimated poses.
        global_localization: Service that restarts the localisation without a known pose.
        navigate_to_pose: Action of Nav2.
        navigate_through_poses: Action of Nav2.
        follow_waypoints: Action of Nav2.
    """

    limits: Limits
    cmd_vel: Name = "cmd_vel"
    odometry: Name = "odom"
    map_frame: Frame = "map"
    initial_pose: Name = "initialpose"
    pose: Name = "amcl_pose"
    global_localization: Name = "reinitialize_global_localization"
    navigate_to_pose: Name = "navigate_to_pose"
    navigate_through_poses: Name = "navigate_through_poses"
    follow_waypoints: Name = "follow_waypoints"


class Gripper(_Part):
    """Gripper.

    Args:
        action: Action `control_msgs/action/GripperCommand`.
        joint: Joint that the action commands.
        closed: Position of the joint at an opening of zero [rad, m].
        per_metre: Travel of the joint per metre of opening [rad/m, m/m].
        widest: Maximum opening [m].
        force: Default force [N].
    """

    action: Name
    joint: Given
    closed: Number
    per_metre: Annotated[Number, AfterValidator(_nonzero)]
    widest: Positive
    force: Positive


class MoveGroup(_Part):
    """Motion planner of an arm, which avoids known obstacles.

    Args:
        action: Action of MoveIt 2.
        group: Planning group of the arm.
    """

    action: Name = "move_action"
    group: Given


class Arm(_Part):
    """Arm.

    Args:
        joints: Joints in order, with their maximum speeds [rad/s].
        limits: Lowest and highest positions of joints [rad]; goals beyond them are refused.
        trajectory: Action `control_msgs/action/FollowJointTrajectory` of the controller.
        joint_states: Topic of joint states.
        base_frame: Frame of the base.
        tool: Frame of the tool, which is moved to poses.
        move_group: Motion planner; without it, joints move straight to their targets.
        gripper: Gripper, if the arm has one.
    """

    joints: Annotated[Mapping[Given, Positive], Field(min_length=1)]
    trajectory: Name
    joint_states: Name = "joint_states"
    base_frame: Frame = "base_link"
    tool: Frame = "tool0"
    move_group: MoveGroup | None = None
    gripper: Gripper | None = None
    limits: Mapping[Given, tuple[Number, Number]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_limits(self) -> Self:
        for name, (lowest, highest) in self.limits.items():
            if name not in self.joints:
                raise ValueError(f"limits of an unknown joint '{name}'; expected one of {', '.join(self.joints)}")
            if lowest >= highest:
                raise ValueError(f"limits of '{name}': expected the lowest position before the highest one")
        return self


class Detector(_Part):
    """Detector of objects in the pictures of a camera.

    Args:
        topic: Topic of `vision_msgs/Detection2DArray`.
        width: Width of the pictures [pixels]; with `height`, actions may require a share of the picture.
        height: Height of the pictures [pixels].
        lowest_score: Lowest score of a detection that counts.
    """

    topic: Name
    width: Annotated[int, Field(strict=True, gt=0)] | None = None
    height: Annotated[int, Field(strict=True, gt=0)] | None = None
    lowest_score: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.5

    key_rules: ClassVar[KeyRules] = (
        KeyCount(("width", "height"), (0, 2), "expected both `width` and `height`, or none of them"),
    )

    @property
    def area(self) -> int | None:
        """Area of the pictures [pixels]; None if it is unknown."""
        return None if self.width is None or self.height is None else self.width * self.height


class Sensors(_Part):
    """Sensors whose measurements a run can wait for, by their names in scenarios.

    Args:
        force: Topics of `geometry_msgs/WrenchStamped`.
        sight: Detectors of objects.
    """

    force: Mapping[Given, Name] = Field(default_factory=dict)
    sight: Mapping[Given, Detector] = Field(default_factory=dict)


class Profile(_Part):
    """Family of robots.

    Args:
        model: Name of the family.
        kinds: Types of actors that the robots can represent, most specific first.
        tf: Topic of transforms.
        tf_static: Topic of static transforms.
        battery: Topic of `sensor_msgs/BatteryState`.
        base: Driving base, if the robots have one.
        arm: Arm, if the robots have one.
        sensors: Force-torque sensors and detectors of objects.
    """

    model: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,63}$")]
    kinds: Annotated[tuple[Given, ...], Field(min_length=1)]
    tf: Name = "tf"
    tf_static: Name = "tf_static"
    battery: Name = "battery_state"
    base: Base | None = None
    arm: Arm | None = None
    sensors: Sensors = Sensors()

    key_rules: ClassVar[KeyRules] = (KeyCount(("base", "arm"), (1, 2), "expected a base, an arm, or both"),)

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the topics and actions that move a robot."""
        return self.actions if self.base is None else (self.base.cmd_vel, *self.actions)

    @property
    def actions(self) -> tuple[str, ...]:
        """Names of the actions."""
        base, arm, names = self.base, self.arm, list[str]()
        if base is not None:
            names += [base.navigate_to_pose, base.navigate_through_poses, base.follow_waypoints]
        if arm is not None:
            names += [arm.trajectory, *(each.action for each in (arm.move_group, arm.gripper) if each is not None)]
        return tuple(names)


@dataclass(frozen=True)
class BridgedRobot:
    """A robot of a bridge: its name in scenarios, its profile, and its namespace in ROS 2."""

    name: str
    profile: Profile
    namespace: str = "/"


def available_profiles() -> tuple[str, ...]:
    """Return the names of the profiles that come with seoro."""
    files = resources.files(__package__).joinpath("profiles").iterdir()
    return tuple(sorted(entry.name.removesuffix(".yaml") for entry in files if entry.name.endswith(".yaml")))


def read_profile(profile: str) -> Profile:
    """Read a profile by its name, or from a file.

    Args:
        profile: One of `available_profiles()`, or the path of a `.yaml` file.

    Raises:
        UsageError: The profile is unknown, or the file is invalid; the message has the file and line.
    """
    try:
        if profile in available_profiles():
            text = resources.files(__package__).joinpath("profiles", f"{profile}.yaml").read_text(encoding="utf-8")
        elif profile.endswith(".yaml"):
            text = read_text(Path(profile))
        else:
            raise UsageError(
                f"unknown profile '{profile}'",
                help=f"profiles: {', '.join(available_profiles())}, or the path of a .yaml file",
            )
        return validate(Profile, read_yaml(text, profile), Lines(text, profile))
    except FileError as error:
        raise UsageError(str(error)) from error
