"""Profiles of surveyed robots."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from typing import Any

import pytest

from seoro.bridges.ros2.adoption.draft import CHECK, Draft
from seoro.bridges.ros2.adoption.drafting import draft_profile, sensor_name
from seoro.bridges.ros2.adoption.finding import find_robots
from seoro.bridges.ros2.adoption.survey import Survey
from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.robots.profile import Profile, read_profile
from seoro.bridges.ros2.urdf import read_links
from tests.bridges.ros2.adoption.graphs import graph_of

UR10E = resources.files("sim_nodes.robots").joinpath("ur10e.urdf").read_text()
TRAJECTORY = "/arm_controller/follow_joint_trajectory"
ARM = [("/arm_controller", "trajectory", TRAJECTORY), ("/broadcaster", "joint_states", "/joint_states")]
BASE = [("/driver", "cmd_vel", "/cmd_vel"), ("/driver", "odometry", "/odom")]
SRDF = """<robot name="ur10e">
  <group name="all"><joint name="x"/><chain base_link="base_link" tip_link="tcp"/></group>
  <group name="ur_manipulator"><chain base_link="base_link" tip_link="tcp"/></group>
  <group name="hand"><joint name="x"/></group>
</robot>"""


def survey_of(
    entities: list[tuple[str, str, str]],
    messages: Mapping[str, Message] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    urdf: str = "",
) -> Survey:
    [robot] = find_robots(graph_of(entities), "bb")
    return Survey(robot, messages or {}, parameters or {}, read_links(urdf) if urdf else None)


def message(types: TypeStore, type_name: str, **members: Any) -> Message:
    return types.decode(type_name, types.encode(type_name, members))


def joint_states(types: TypeStore, *names: str) -> Message:
    return message(types, "sensor_msgs/msg/JointState", name=list(names))


def profile_of(draft: Draft) -> Profile:
    return Profile.model_validate(draft.values)


def questions(draft: Draft) -> list[str]:
    return [question.text for question in draft.questions]


def test_a_base_without_stated_limits_gets_cautious_ones() -> None:
    draft = draft_profile(survey_of(BASE))
    base = profile_of(draft).base
    assert base is not None
    assert (base.limits.linear, base.limits.angular) == (0.2, 0.5)
    assert questions(draft) == ["maximum forward speed [m/s]", "maximum turn rate [rad/s]"]
    assert draft.notes[("base", "limits", "linear")].startswith(f"{CHECK}: ")
    assert draft.notes[("base", "odometry")] == "found: /odom of /driver, nav_msgs/msg/Odometry"
    assert any("no navigation" in remark for remark in draft.remarks)


@pytest.mark.parametrize(
    ("parameters", "linear", "angular"),
    [
        ({"/driver": {"linear.x.max_velocity": 0.7, "angular.z.max_velocity": 2}}, 0.7, 2.0),
        ({"/velocity_smoother": {"max_velocity": [0.4, 0.0, 1.5]}}, 0.4, 1.5),
        (
            {
                "/velocity_smoother": {"max_velocity": [0.4, 0.0, 1.5]},
                "/driver": {"linear.x.max_velocity": 0.7, "angular.z.max_velocity": True},
            },
            0.7,
            1.5,
        ),
        ({"/controller_server": {"FollowPath.vx_max": 0.3, "FollowPath.wz_max": 0.9}}, 0.3, 0.9),
    ],
)
def test_limits_come_from_parameters(parameters: dict[str, Any], linear: float, angular: float) -> None:
    draft = draft_profile(survey_of(BASE, parameters=parameters))
    base = profile_of(draft).base
    assert base is not None
    assert (base.limits.linear, base.limits.angular) == (linear, angular)
    assert not draft.questions


def test_an_answer_sets_its_values() -> None:
    draft = draft_profile(survey_of(BASE))
    draft.answer(draft.questions[0], 0.35)
    base = profile_of(draft).base
    assert base is not None
    assert base.limits.linear == 0.35
    assert CHECK not in draft.notes[("base", "limits", "linear")]
    assert questions(draft) == ["maximum turn rate [rad/s]"]


def test_an_arm_has_the_joints_limits_and_frames_of_its_description(types: TypeStore) -> None:
    expected = read_profile("ur10e").arm
    assert expected is not None
    parameters = {"/arm_controller": {"joints": [*expected.joints]}}
    entities = [
        *ARM,
        ("/move_group", "move_group", "/move_action"),
        ("/d", "semantics", "/robot_description_semantic"),
    ]
    semantics = {"/robot_description_semantic": message(types, "std_msgs/msg/String", data=SRDF)}
    draft = draft_profile(survey_of(entities, semantics, parameters, UR10E))
    arm = profile_of(draft).arm
    assert arm is not None
    assert dict(arm.joints) == pytest.approx(dict(expected.joints), abs=1e-3)
    assert arm.limits.keys() == expected.limits.keys()
    assert arm.limits["elbow_joint"] == pytest.approx(expected.limits["elbow_joint"], abs=1e-3)
    assert (arm.base_frame, arm.tool, arm.trajectory) == ("base_link", "tcp", TRAJECTORY[1:])
    assert arm.move_group is not None
    assert arm.move_group.group == "ur_manipulator"
    assert not draft.questions


def test_joints_without_a_description_have_one_question(types: TypeStore) -> None:
    states = {"/joint_states": joint_states(types, "left_wheel_joint", "elbow", "shoulder", "finger_joint")}
    draft = draft_profile(survey_of(ARM, states))
    arm = profile_of(draft).arm
    assert arm is not None
    assert [*arm.joints] == ["elbow", "shoulder"]
    assert questions(draft) == ["maximum speed of elbow, shoulder [rad/s]"]
    draft.answer(draft.questions[0], 1.5)
    assert profile_of(draft).arm == arm.model_copy(update={"joints": {"elbow": 1.5, "shoulder": 1.5}})


def test_the_controller_with_most_joints_is_the_arm() -> None:
    entities = [*ARM, ("/a_hand", "trajectory", "/a_hand/follow_joint_trajectory")]
    parameters = {"/arm_controller": {"joints": ["a", "b"]}, "/a_hand": {"joints": ["c"]}}
    draft = draft_profile(survey_of(entities, parameters=parameters))
    assert draft.values["arm"]["trajectory"] == TRAJECTORY[1:]
    assert "/a_hand/follow_joint_trajectory" in draft.notes[("arm", "trajectory")]


def test_an_arm_without_names_of_joints_is_left_out() -> None:
    draft = draft_profile(survey_of(ARM))
    assert "arm" not in draft.values
    assert any(remark.startswith(f"{CHECK}: {TRAJECTORY}") for remark in draft.remarks)


FINGERS = """<robot name="r">
  <joint name="j" type="revolute"><parent link="base_link"/><child link="wrist"/>
    <limit lower="-1" upper="1" velocity="2" effort="1"/></joint>
  <joint name="left_finger" type="prismatic"><parent link="wrist"/><child link="l"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
  <joint name="right_finger" type="prismatic"><parent link="wrist"/><child link="r"/><mimic joint="left_finger"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
</robot>"""
GRIPPER = [*ARM, ("/gripper_controller", "gripper", "/gripper_controller/gripper_cmd")]
CONTROLLED = {"/arm_controller": {"joints": ["j"]}}


def test_mimicking_fingers_open_twice_as_far() -> None:
    arm = profile_of(draft_profile(survey_of(GRIPPER, parameters=CONTROLLED, urdf=FINGERS))).arm
    assert arm is not None
    assert arm.gripper is not None
    assert (arm.gripper.joint, arm.gripper.closed, arm.gripper.per_metre, arm.gripper.widest) == (
        "left_finger",
        0.0,
        0.5,
        0.08,
    )


def test_the_travel_of_a_knuckle_follows_from_the_opening() -> None:
    knuckle = FINGERS.replace("prismatic", "revolute").replace('upper="0.04"', 'upper="0.8"')
    draft = draft_profile(survey_of(GRIPPER, parameters=CONTROLLED, urdf=knuckle))
    [opening] = [each for each in draft.questions if "opening" in each.text]
    draft.answer(opening, 0.1)
    arm = profile_of(draft).arm
    assert arm is not None
    assert arm.gripper is not None
    assert (arm.gripper.closed, arm.gripper.per_metre, arm.gripper.widest) == (0.8, -8.0, 0.1)


def test_sensors_are_named_by_their_topics(types: TypeStore) -> None:
    entities = [
        *BASE,
        ("/ft", "force", "/wrist/wrench"),
        ("/eye", "sight", "/camera/detections"),
        ("/eye", "camera", "/camera/camera_info"),
        ("/eye", "camera", "/rear/camera_info"),
    ]
    info = message(types, "sensor_msgs/msg/CameraInfo", width=640, height=480)
    sensors = profile_of(draft_profile(survey_of(entities, {"/camera/camera_info": info}))).sensors
    assert sensors.force == {"wrist": "wrist/wrench"}
    assert (sensors.sight["camera"].topic, sensors.sight["camera"].area) == ("camera/detections", 640 * 480)


def test_frames_of_the_map_come_from_navigation() -> None:
    draft = draft_profile(survey_of(BASE, parameters={"/amcl": {"global_frame_id": "site"}}))
    assert draft.values["base"]["map_frame"] == "site"


@pytest.mark.parametrize(
    ("topic", "name"), [("/wrist/wrench", "wrist"), ("/wrench", "wrench"), ("/ft/raw", "raw"), ("/x", "x")]
)
def test_names_of_sensors(topic: str, name: str) -> None:
    assert sensor_name(topic, "wrench") == name
