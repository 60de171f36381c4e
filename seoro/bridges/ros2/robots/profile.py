"""Profiles: what a family of robots is, and what it calls its topics, services, actions and frames.

Names without a leading slash are below the namespace of the robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Annotated, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from seoro.bridges.ros2.wire.names import InvalidName, resolve
from seoro.errors import InvalidUse
from seoro.yaml_files import FileError, Lines, problems, read_text, read_yaml


def _of_the_robot(name: str) -> str:
    if name.startswith("~"):
        raise ValueError("a private name is that of a node: write out the topic, service or action of the robot")
    try:
        resolve(name, "/", "robot")
    except InvalidName as error:
        raise ValueError(str(error)) from error
    return name


def _not_zero(value: float) -> float:
    if value == 0.0:
        raise ValueError("Input should not be 0")
    return value


Name = Annotated[str, AfterValidator(_of_the_robot)]
Frame = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_/]{0,200}$")]
Given = Annotated[str, Field(min_length=1)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0.0)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Limits(_Part):
    """The fastest that commands may ask a base for: ahead or back [m/s], and turning [rad/s]."""

    linear: Positive
    angular: Positive


class Base(_Part):
    """A base that drives.

    Args:
        limits: Of commands of velocity; the navigation on the robot has its own.
        cmd_vel: Topic of commands of velocity, `Twist` or `TwistStamped` as whoever subscribes says.
        odometry: Topic of `nav_msgs/Odometry`.
        map_frame: Frame in which poses of goals are.
        initial_pose: Topic on which the localisation is told where the robot is.
        pose: Topic on which the localisation says that.
        global_localization: Service that makes the localisation start over everywhere.
        navigate_to_pose: Nav2's actions.
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
    """A gripper.

    Args:
        action: Its action, a `control_msgs/action/GripperCommand`.
        joint: The joint whose position the action commands.
        closed: Position of that joint at an opening of zero [rad, m].
        per_metre: How much further it is for each metre of opening [rad/m, m/m].
        widest: Opening [m].
        force: With which it presses when nothing else is asked for [N].
    """

    action: Name
    joint: Given
    closed: Number
    per_metre: Annotated[Number, AfterValidator(_not_zero)]
    widest: Positive
    force: Positive


class MoveGroup(_Part):
    """What plans the motions of an arm, so that it runs into nothing that is known.

    Args:
        action: Action of MoveIt 2.
        group: Its group of the joints.
    """

    action: Name = "move_action"
    group: Given


class Arm(_Part):
    """An arm.

    Args:
        joints: Its joints in order, with the speed that each can have [rad/s].
        trajectory: Action `control_msgs/action/FollowJointTrajectory` of its controller.
        joint_states: Topic of the positions of the joints.
        base_frame: Frame of its base.
        tool: Frame of its tool, which is moved to poses.
        move_group: What plans motions; without it, joints move straight to where they are told to.
        gripper: Its gripper, if it has one.
    """

    joints: Annotated[Mapping[Given, Positive], Field(min_length=1)]
    trajectory: Name
    joint_states: Name = "joint_states"
    base_frame: Frame = "base_link"
    tool: Frame = "tool0"
    move_group: MoveGroup | None = None
    gripper: Gripper | None = None


class Profile(_Part):
    """A family of robots.

    Args:
        model: What it is called.
        kinds: Types of actors that it can stand for, most specific first.
        tf: Topic of transforms that change.
        tf_static: Topic of transforms that do not.
        battery: Topic of `sensor_msgs/BatteryState`.
        base: Its base, if it drives.
        arm: Its arm, if it has one.
    """

    model: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,63}$")]
    kinds: Annotated[tuple[Given, ...], Field(min_length=1)]
    tf: Name = "tf"
    tf_static: Name = "tf_static"
    battery: Name = "battery_state"
    base: Base | None = None
    arm: Arm | None = None

    @model_validator(mode="after")
    def _does_something(self) -> Self:
        if self.base is None and self.arm is None:
            raise ValueError("a robot has a base, or an arm, or both")
        return self

    @property
    def commands(self) -> tuple[str, ...]:
        """The names of all that makes it move."""
        return self.actions if self.base is None else (self.base.cmd_vel, *self.actions)

    @property
    def actions(self) -> tuple[str, ...]:
        """The names of its actions."""
        base, arm, names = self.base, self.arm, list[str]()
        if base is not None:
            names += [base.navigate_to_pose, base.navigate_through_poses, base.follow_waypoints]
        if arm is not None:
            names += [arm.trajectory, *(each.action for each in (arm.move_group, arm.gripper) if each is not None)]
        return tuple(names)


def available_profiles() -> tuple[str, ...]:
    """Names of the profiles that come with seoro."""
    files = resources.files(__package__).joinpath("profiles").iterdir()
    return tuple(sorted(entry.name.removesuffix(".yaml") for entry in files if entry.name.endswith(".yaml")))


def read_profile(profile: str) -> Profile:
    """The profile of a name, or in a file.

    Args:
        profile: One of `available_profiles()`, or the path of a `.yaml` file.

    Raises:
        InvalidUse: There is none, or the file is wrong; the message has the file and the line.
    """
    try:
        if profile in available_profiles():
            text = resources.files(__package__).joinpath("profiles", f"{profile}.yaml").read_text(encoding="utf-8")
        elif profile.endswith(".yaml"):
            text = read_text(Path(profile))
        else:
            raise InvalidUse(
                f"there is no profile '{profile}'",
                help=f"profiles: {', '.join(available_profiles())}, or the path of a .yaml file",
            )
        content = read_yaml(text, profile)
        lines = Lines(text, profile)
        return Profile.model_validate(content)
    except FileError as error:
        raise InvalidUse(str(error)) from error
    except ValidationError as error:
        raise InvalidUse(problems(error, lines, Profile)) from error
