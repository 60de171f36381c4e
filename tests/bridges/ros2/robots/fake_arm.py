"""A fake of an arm with MoveIt 2, as the bridge sees it: `python fake_arm.py FOLDER ROUTER NAME`.

Joints follow trajectories in time; goals of MoveIt are reached at once, and fail for joints beyond 3 rad.
Closing fingers stop at an opening of 0.03 m. The arm writes its goals to a file, as JSON.
"""

from __future__ import annotations

import json
import math
import sys
import time
from functools import partial
from pathlib import Path

import anyio

from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.robots.profile import read_profile
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import RmwZenoh

TICK = 0.02  # [s]
NUMB = 13.0  # [N] effort of goals whose result has no position
FOLLOWS = "control_msgs/action/FollowJointTrajectory"
GRIPS = "control_msgs/action/GripperCommand"
PLANS = "moveit_msgs/action/MoveGroup"


class Arm:
    """Positions and action servers of the arm and its gripper."""

    def __init__(self, file: Path, types: TypeStore) -> None:
        self._file = file
        self._types = types
        profile = read_profile("ur10e").arm
        assert profile is not None
        assert profile.gripper is not None
        self.profile, self.gripper = profile, profile.gripper
        self.joints = dict.fromkeys(profile.joints, 0.0)
        self.finger = 0.0  # open

    def note(self, kind: str, goal: GoalHandle) -> None:
        with self._file.open("a") as file:
            file.write(json.dumps([kind, self._types.plain(f"{kind}_Goal", goal.goal)]) + "\n")

    async def publish(self, states: Publication) -> None:
        while True:
            positions = [*self.joints.values(), self.finger]
            states.publish({"name": [*self.joints, self.gripper.joint], "position": positions})
            await anyio.sleep(TICK)

    async def publish_tool(self, transforms: Publication) -> None:
        while True:
            pose = {"translation": {"x": 0.5, "z": 0.4}, "rotation": {"w": 1.0}}
            transform = {
                "header": geometry.header("base_link", time.time()),
                "child_frame_id": "tool0",
                "transform": pose,
            }
            transforms.publish({"transforms": [transform]})
            await anyio.sleep(TICK)

    async def follow(self, goal: GoalHandle) -> GoalEnd:
        self.note(FOLLOWS, goal)
        trajectory, elapsed = goal.goal.trajectory, 0.0
        for point in trajectory.points:
            until = geometry.seconds(point.time_from_start)
            await anyio.sleep(until - elapsed)
            elapsed = until
            self.joints.update(zip(trajectory.joint_names, map(float, point.positions), strict=True))
        return GoalEnd(Status.SUCCEEDED)

    async def plan(self, goal: GoalHandle) -> GoalEnd:
        self.note(PLANS, goal)
        wanted = goal.goal.request.goal_constraints[0].joint_constraints
        if any(each.position > 3.0 for each in wanted):
            return GoalEnd(Status.ABORTED, {"error_code": {"val": -12}})
        if not goal.goal.planning_options.plan_only:
            self.joints.update({each.joint_name: each.position for each in wanted})
        return GoalEnd(Status.SUCCEEDED, {"error_code": {"val": 1}})

    async def grip(self, goal: GoalHandle) -> GoalEnd:
        self.note(GRIPS, goal)
        stopped = self.gripper.closed + self.gripper.per_metre * 0.03
        wanted = float(goal.goal.command.position)
        stalled = wanted > stopped
        self.finger = min(wanted, stopped)
        result = {"position": self.finger, "stalled": stalled, "reached_goal": not stalled}
        if goal.goal.command.max_effort == NUMB:
            result |= {"position": math.nan, "stalled": True, "reached_goal": False}
        return GoalEnd(Status.SUCCEEDED, result)


async def main(folder: str, router: str, name: str) -> None:
    """Simulate the arm until the process is killed."""
    types = TypeStore.bundled()
    arm = Arm(Path(folder) / name, types)
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as system,
        system.node("arm", f"/{name}") as node,
        node.publishing("joint_states", "sensor_msgs/msg/JointState") as states,
        node.publishing("tf", "tf2_msgs/msg/TFMessage") as transforms,
        serving_action(node, arm.profile.trajectory, FOLLOWS, arm.follow),
        serving_action(node, "move_action", PLANS, arm.plan),
        serving_action(node, arm.gripper.action, GRIPS, arm.grip),
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(arm.publish, states)
        tasks.start_soon(arm.publish_tool, transforms)
        sys.stdout.write("ready\n")
        sys.stdout.flush()


if __name__ == "__main__":
    anyio.run(partial(main, *sys.argv[1:]))
