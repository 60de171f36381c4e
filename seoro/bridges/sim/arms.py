"""Arms with grippers; see `Arms`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.robotics.geometry import Pose3D
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.robots import ArmState, MotionOptions


class ArmRequests(Requests):
    """The capability `Arms` of a node."""

    async def move_joints(
        self,
        robot: str,
        positions: Sequence[float],
        names: Sequence[str],
        options: MotionOptions,
        report: Reporter,
    ) -> str:
        """See `Arms`."""
        request = wire.FollowJointTrajectory(
            id=self.new_id("goal"),
            robot=robot,
            points=(tuple(positions),),
            joint_names=tuple(names),
            **_motion(options),
        )
        return await self.start(wire.FOLLOW_JOINT_TRAJECTORY, request, report)

    async def move_tool(
        self, robot: str, pose: Pose3D, frame: str, options: MotionOptions, report: Reporter, *, straight: bool
    ) -> str:
        """See `Arms`."""
        request = wire.MoveToPose(
            id=self.new_id("goal"), robot=robot, pose=pose, frame=frame, straight=straight, **_motion(options)
        )
        return await self.start(wire.MOVE_TO_POSE, request, report)

    async def move_gripper(
        self, robot: str, opening: float, force: float | None, options: MotionOptions, report: Reporter
    ) -> str:
        """See `Arms`."""
        request = wire.GripperCommand(
            id=self.new_id("goal"),
            robot=robot,
            opening=opening,
            force=force,
            max_velocity_scaling_factor=options.scaling,
            tolerance=options.tolerance,
        )
        return await self.start(wire.GRIPPER_COMMAND, request, report)

    async def hold_entity(self, robot: str, entity: str, duration: float, report: Reporter) -> str:
        """See `Arms`."""
        request = wire.HoldEntity(id=self.new_id("goal"), robot=robot, entity=entity, duration=duration)
        return await self.start(wire.HOLD_ENTITY, request, report)

    async def watch_joint(
        self, robot: str, joint: str, position: float, tolerance: float, report: Reporter
    ) -> str:
        """See `Arms`."""
        request = wire.WatchJoint(
            id=self.new_id("watch"), robot=robot, joint=joint, position=position, tolerance=tolerance
        )
        return await self.start(wire.WATCH_JOINT, request, report)

    async def arm_state(self, robot: str) -> ArmState:
        """See `Arms`."""
        state = await self.ask(wire.GET_ARM_STATE, wire.RobotName(robot=robot))
        return ArmState(state.tool, state.opening, state.held)


def _motion(options: MotionOptions) -> dict[str, Any]:
    return {
        "max_velocity_scaling_factor": options.scaling,
        "tolerance": options.tolerance,
        "may_touch": options.may_touch,
        "plan_only": options.plan_only,
        "replan": options.replan,
    }
