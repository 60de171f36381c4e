"""A fake of a robot with Nav2, for the bridge: `python fake_robot.py FOLDER ROUTER NAME TWIST [ros2dds]`.

It follows velocities, and goals in straight lines without obstacles; goals are relative to its pose. Goals at
x = 13 are rejected and at x = 66 aborted; at x = 99 the robot never answers. It writes notes with the time of the
machine's clock to a file: received velocities, and starts and ends of goals.
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
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D

TICK = 0.02  # [s]
SPEED = 1.0  # [m/s] of goals
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
EXECUTING, SUCCEEDED, CANCELED, ABORTED = 2, 4, 5, 6


class Robot:
    """State and commands of the robot."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self.x = self.y = self.yaw = 0.0  # in the frame odom
        self.linear = self.angular = 0.0
        self.map_offset: tuple[float, float] | None = None  # offset of odom in the map
        self.goals: dict[bytes, list[tuple[float, float]]] = {}
        self.ends: dict[bytes, int] = {}
        self.canceled: set[bytes] = set()
        self.hopeless: set[bytes] = set()
        self.statuses: dict[bytes, Publication] = {}  # publishers by goal
        self.note("ready", 0.0)

    def note(self, what: str, value: float) -> None:
        """Append a note to the file."""
        with self._log.open("a") as file:
            file.write(f"{time.monotonic()} {what} {value}\n")

    def command(self, message: Any) -> None:
        """Apply a velocity command."""
        twist = message.twist if hasattr(message, "twist") else message
        self.linear, self.angular = twist.linear.x, twist.angular.z
        self.note("velocity", self.linear)

    def step(self) -> None:
        """Move for one tick."""
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
        self.publish_status(number, status)

    def publish_status(self, number: bytes, status: int) -> None:
        """Publish the status of a goal."""
        info = {"goal_id": {"uuid": list(number)}}
        self.statuses[number].publish({"status_list": [{"goal_info": info, "status": status}]})

    def _reach(self, x: float, y: float) -> bool:
        left = math.dist((x, y), (self.x, self.y))
        share = min(1.0, SPEED * TICK / left) if left else 1.0
        self.x += (x - self.x) * share
        self.y += (y - self.y) * share
        return share == 1.0

    def pose(self) -> dict[str, Any]:
        return geometry.pose_message(Pose3D(Position3D(self.x, self.y), Orientation3D(yaw=self.yaw)))


async def _obey(robot: Robot, commands: Subscription) -> None:
    while True:
        robot.command(await commands.message())


async def _localise(robot: Robot, initial_poses: Subscription, poses: Publication) -> None:
    while True:
        message = await initial_poses.message()
        place = message.pose.pose.position
        robot.map_offset = (place.x - robot.x, place.y - robot.y)
        robot.note("initial_pose", place.x)
        poses.publish({"header": {"frame_id": "map"}, "pose": {"pose": message.pose.pose}})


async def _live(robot: Robot, odometry: Publication, transforms: Publication) -> None:
    while True:
        await anyio.sleep(TICK)
        robot.step()
        odometry.publish({"pose": {"pose": robot.pose()}, "child_frame_id": "base_link"})
        pose = robot.pose()
        known = [_transform("odom", "base_link", pose["position"], pose["orientation"])]
        if robot.map_offset is not None:
            x, y = robot.map_offset
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
    robot.publish_status(number, EXECUTING)
    content = {"number_of_recoveries": 2} if feedback.type.startswith("nav2_msgs/action/Navigate") else {}
    feedback.publish({"goal_id": {"uuid": list(number)}, "feedback": content})
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
    """Simulate the robot until the process is killed."""
    spoken = RmwZenoh() if dialect == "rmw_zenoh" else Ros2Dds()
    robot = Robot(Path(folder) / name)
    async with (
        connect(router, dialect=spoken) as system,
        system.node("robot", f"/{name}") as node,
        node.subscribing("cmd_vel", twist) as commands,
        node.subscribing("initialpose", POSE) as initial_poses,
        node.publishing("odom", "nav_msgs/msg/Odometry") as odometry,
        node.publishing("tf", "tf2_msgs/msg/TFMessage") as transforms,
        node.publishing("amcl_pose", POSE, LATCHED) as poses,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(_obey, robot, commands)
        tasks.start_soon(_localise, robot, initial_poses, poses)
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
