"""Arms with grippers; see `Arms` for what the methods do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.sim.messages import pose_message, pose_value
from seoro.bridges.sim.requests import Requests
from seoro.runtime.capabilities import ArmState, Manner
from seoro.runtime.contracts import Pose3D, Reporter


class ArmRequests(Requests):
    """The capability `Arms` of a node."""

    async def move_joints(
        self, robot: str, positions: Sequence[float], names: Sequence[str], manner: Manner, report: Reporter
    ) -> str:
        """See `Arms`."""
        goal = self._expect(report)
        request = wire.FollowJointTrajectory(
            id=goal, robot=robot, points=(tuple(positions),), joint_names=tuple(names), **_motion(manner)
        )
        return await self.ask_reported(wire.FOLLOW_JOINT_TRAJECTORY, request, goal)

    async def move_tool(
        self, robot: str, pose: Pose3D, frame: str, manner: Manner, report: Reporter, *, straight: bool
    ) -> str:
        """See `Arms`."""
        goal = self._expect(report)
        request = wire.MoveToPose(
            id=goal, robot=robot, pose=pose_message(pose), frame=frame, straight=straight, **_motion(manner)
        )
        return await self.ask_reported(wire.MOVE_TO_POSE, request, goal)

    async def move_gripper(
        self, robot: str, opening: float, force: float | None, manner: Manner, report: Reporter
    ) -> str:
        """See `Arms`."""
        goal = self._expect(report)
        request = wire.GripperCommand(
            id=goal,
            robot=robot,
            opening=opening,
            force=force,
            max_velocity_scaling_factor=manner.scaling,
            tolerance=manner.tolerance,
        )
        return await self.ask_reported(wire.GRIPPER_COMMAND, request, goal)

    async def hold_entity(self, robot: str, entity: str, duration: float, report: Reporter) -> str:
        """See `Arms`."""
        goal = self._expect(report)
        request = wire.HoldEntity(id=goal, robot=robot, entity=entity, duration=duration)
        return await self.ask_reported(wire.HOLD_ENTITY, request, goal)

    async def watch_joint(
        self, robot: str, joint: str, position: float, tolerance: float, report: Reporter
    ) -> str:
        """See `Arms`."""
        watch = self.new_id("watch")
        self._reporters[watch] = report
        request = wire.WatchJoint(id=watch, robot=robot, joint=joint, position=position, tolerance=tolerance)
        return await self.ask_reported(wire.WATCH_JOINT, request, watch)

    async def arm_state(self, robot: str) -> ArmState:
        """See `Arms`."""
        state = await self.ask(wire.GET_ARM_STATE, wire.RobotName(robot=robot))
        return ArmState(pose_value(state.tool), state.opening, state.held)

    def _expect(self, report: Reporter) -> str:
        """The id of a new goal, whose end goes to a reporter."""
        goal = self.new_id("goal")
        self._reporters[goal] = report
        return goal


def _motion(manner: Manner) -> dict[str, Any]:
    return {
        "max_velocity_scaling_factor": manner.scaling,
        "tolerance": manner.tolerance,
        "may_touch": manner.may_touch,
        "plan_only": manner.plan_only,
        "replan": manner.replan,
    }
