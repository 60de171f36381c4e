"""A robot of ROS 2 with Nav2, for the bridge: `python fake_robot.py FOLDER ROUTER NAME TWIST [ros2dds]`.

It drives as it is told by velocity or by goals, in straight lines and without anything in its way; goals are seen
from where it is. Those at x = 13 are rejected, at x = 66 aborted, and at x = 99 it never answers. It notes in a
file what moves it, with the machine's clock: velocities that it has from others, and goals that begin and end.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import anyio

from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.wire import Durability, Qos, RmwZenoh, Ros2Dds
from seoro.bridges.wire import Orientation, Pose, Vector3

TICK = 0.02  # [s]
SPEED = 1.0  # [m/s] of goals
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
EXECUTING, SUCCEEDED, CANCELED, ABORTED = 2, 4, 5, 6


class Robot:
    """Where the robot is, and what moves it."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self.x = self.y = self.yaw = 0.0  # in the frame odom
        self.linear = self.angular = 0.0
        self.told: tuple[float, float] | None = None  # where it is in the map, at the beginning
        self.goals: dict[bytes, list[tuple[float, float]]] = {}
        self.ends: dict[bytes, int] = {}
        self.canceled: set[bytes] = set()
        self.hopeless: set[bytes] = set()
        self.statuses: dict[bytes, Publication] = {}  # where it is told how far goals are
        self.note("ready", 0.0)

    def note(self, what: str, value: float) -> None:
        """Write something down."""
        with self._log.open("a") as file:
            file.write(f"{time.monotonic()} {what} {value}\n")

    def command(self, message: Any) -> None:
        """Obey a command of velocity."""
        twist = message.twist if hasattr(message, "twist") else message
        self.linear, self.angular = twist.linear.x, twist.angular.z
        self.note("velocity", self.linear)

    def step(self) -> None:
        """Move on."""
        self.x += self.linear * math.cos(self.yaw) * TICK
        self.y += self.linear * math.sin(self.yaw) * TICK
        self.yaw += self.angular * TICK
        for number, targets in list(self.goals.items()):
            if number in self.canceled:
                self._end(number, CANCELED)
            elif number in self.hopeless:
                self._end(number, ABORTED)
            elif self._reach(*targets[0]):
                targets.pop(0)
                if not targets:
                    self._end(number, SUCCEEDED)

    def _end(self, number: bytes, status: int) -> None:
        del self.goals[number]
        self.ends[number] = status
        self.note("goal", -float(status))
        self.tell(number, status)

    def tell(self, number: bytes, status: int) -> None:
        """Tell how far a goal is."""
        info = {"goal_id": {"uuid": list(number)}}
        self.statuses[number].publish({"status_list": [{"goal_info": info, "status": status}]})

    def _reach(self, x: float, y: float) -> bool:
        left = math.dist((x, y), (self.x, self.y))
        share = min(1.0, SPEED * TICK / left) if left else 1.0
        self.x += (x - self.x) * share
        self.y += (y - self.y) * share
        return share == 1.0

    def pose(self) -> dict[str, Any]:
        """Where it is."""
        return geometry.pose_message(
            Pose(position=Vector3(x=self.x, y=self.y), orientation=Orientation(yaw=self.yaw))
        )


async def _obey(robot: Robot, commands: Subscription) -> None:
    while True:
        robot.command(await commands.message())


async def _localise(robot: Robot, told: Subscription, poses: Publication) -> None:
    while True:
        message = await told.message()
        place = message.pose.pose.position
        robot.told = (place.x - robot.x, place.y - robot.y)
        robot.note("told", place.x)
        poses.publish({"header": {"frame_id": "map"}, "pose": {"pose": message.pose.pose}})


async def _live(robot: Robot, odometry: Publication, transforms: Publication) -> None:
    while True:
        await anyio.sleep(TICK)
        robot.step()
        odometry.publish({"pose": {"pose": robot.pose()}, "child_frame_id": "base_link"})
        pose = robot.pose()
        known = [_transform("odom", "base_link", pose["position"], pose["orientation"])]
        if robot.told is not None:
            x, y = robot.told
            known.append(_transform("map", "odom", {"x": x, "y": y}, {"w": 1.0}))
        transforms.publish({"transforms": known})


def _transform(parent: str, child: str, place: Mapping[str, float], turn: Mapping[str, float]) -> dict[str, Any]:
    return {
        "header": geometry.header(parent, time.time()),
        "child_frame_id": child,
        "transform": {"translation": place, "rotation": turn},
    }


async def _take(robot: Robot, request: Any, feedback: Publication, statuses: Publication) -> dict[str, Any]:
    goal, number = request.goal, bytes(request.goal_id.uuid)
    poses = goal.poses if hasattr(goal, "poses") else [goal.pose]
    targets = [(each.pose.position.x, each.pose.position.y) for each in poses]
    if targets[0][0] == 99.0:
        await anyio.sleep_forever()
    if targets[0][0] == 13.0:
        return {"accepted": False}
    if targets[0][0] == 66.0:
        robot.hopeless.add(number)
    robot.goals[number] = [(x + robot.x, y + robot.y) for x, y in targets]
    robot.note("goal", len(targets))
    robot.statuses[number] = statuses
    robot.tell(number, EXECUTING)
    told = {"number_of_recoveries": 2} if feedback.type.startswith("nav2_msgs/action/Navigate") else {}
    feedback.publish({"goal_id": {"uuid": list(number)}, "feedback": told})
    return {"accepted": True}


async def _result(robot: Robot, request: Any) -> dict[str, Any]:
    number = bytes(request.goal_id.uuid)
    while number not in robot.ends:
        await anyio.sleep(TICK)
    return {"status": robot.ends[number]}


async def _cancel(robot: Robot, request: Any) -> dict[str, Any]:
    number = bytes(request.goal_info.goal_id.uuid)
    robot.canceled.add(number)
    return {"return_code": 0, "goals_canceling": [{"goal_id": {"uuid": list(number)}}]}


async def _serve(robot: Robot, node: RosNode, name: str, type_name: str) -> None:
    under = f"{name}/_action"
    async with (
        node.publishing(f"{under}/feedback", f"{type_name}_FeedbackMessage") as feedback,
        node.publishing(f"{under}/status", "action_msgs/msg/GoalStatusArray", LATCHED) as statuses,
        node.serving(
            f"{under}/send_goal",
            f"{type_name}_SendGoal",
            lambda request: _take(robot, request, feedback, statuses),
        ),
        node.serving(f"{under}/get_result", f"{type_name}_GetResult", partial(_result, robot)),
        node.serving(f"{under}/cancel_goal", "action_msgs/srv/CancelGoal", partial(_cancel, robot)),
    ):
        await anyio.sleep_forever()


async def main(folder: str, router: str, name: str, twist: str, dialect: str = "rmw_zenoh") -> None:
    """Be a robot until the process is killed."""
    spoken = RmwZenoh() if dialect == "rmw_zenoh" else Ros2Dds()
    robot = Robot(Path(folder) / name)
    async with (
        connect(router, dialect=spoken) as system,
        system.node("robot", f"/{name}") as node,
        node.subscribing("cmd_vel", twist) as commands,
        node.subscribing("initialpose", POSE) as told,
        node.publishing("odom", "nav_msgs/msg/Odometry") as odometry,
        node.publishing("tf", "tf2_msgs/msg/TFMessage") as transforms,
        node.publishing("amcl_pose", POSE, LATCHED) as poses,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(_obey, robot, commands)
        tasks.start_soon(_localise, robot, told, poses)
        tasks.start_soon(_live, robot, odometry, transforms)
        for action, kind in (
            ("navigate_to_pose", "NavigateToPose"),
            ("navigate_through_poses", "NavigateThroughPoses"),
            ("follow_waypoints", "FollowWaypoints"),
        ):
            tasks.start_soon(_serve, robot, node, action, f"nav2_msgs/action/{kind}")
        sys.stdout.write("ready\n")
        sys.stdout.flush()


if __name__ == "__main__":
    anyio.run(partial(main, *sys.argv[1:]))
