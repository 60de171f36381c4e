"""Robots that drive and arms with grippers; see the contracts in `seoro.runtime.contracts.robots`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests, twist_message
from seoro.bridges.sim.rules import check_deviation
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.people import Point
from seoro.runtime.contracts.robots import ArmState, MotionOptions

CMD_VEL = "cmd_vel"
FEEDBACK_PERIOD = 1.0  # [s] between two reports of progress


class RobotRequests(Requests):
    """The capabilities `MobileRobots`, `LocalisedRobots`, `DrivenRobots`, `PathRobots`, `Arms` and `Postures`."""

    async def cancel_goal(self, goal: str) -> None:
        """See `MobileRobots`."""
        await self.cancel_report(wire.CANCEL_GOAL, wire.CancelGoal(id=goal), goal)

    async def cancel_watch(self, watch: str) -> None:
        """See `MobileRobots`."""
        await self.cancel_report(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)

    # ------------------------------------------------------------ robots that drive

    async def set_initial_pose(self, robot: str, pose: Pose3D) -> None:
        """See `MobileRobots`."""
        await self.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=robot, pose=pose))

    async def navigate(self, robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        """See `MobileRobots`."""
        request = wire.NavigateThroughPoses(
            id=self.new_id("goal"),
            robot=robot,
            poses=tuple(poses),
            stop_at_each=stop_at_each,
            feedback_period=FEEDBACK_PERIOD,
        )
        return await self.start(wire.NAVIGATE_THROUGH_POSES, request, report)

    async def watch_proximity(
        self, robot: str, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """See `MobileRobots`."""
        request = wire.WatchProximity(
            id=self.new_id("watch"),
            robot=robot,
            frame=frame,
            parent_frame=parent_frame,
            point=point,
            threshold=threshold,
        )
        return await self.start(wire.WATCH_PROXIMITY, request, report)

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """See `MobileRobots`."""
        request = wire.WatchDistance(id=self.new_id("watch"), robot=robot, distance=distance)
        return await self.start(wire.WATCH_DISTANCE, request, report)

    async def reinitialize_global_localization(self, robot: str) -> None:
        """See `LocalisedRobots`."""
        await self.ask(wire.REINITIALIZE_GLOBAL_LOCALIZATION, wire.RobotName(robot=robot))

    async def watch_localization(self, robot: str, report: Reporter) -> str:
        """See `LocalisedRobots`."""
        request = wire.WatchLocalization(id=self.new_id("watch"), robot=robot)
        return await self.start(wire.WATCH_LOCALIZATION, request, report)

    async def localization_error(self, robot: str) -> float | None:
        """See `LocalisedRobots`."""
        error = (await self.ask(wire.GET_LOCALIZATION, wire.RobotName(robot=robot))).error
        if error is not None:
            check_deviation(self.name, f"the error of the localisation of '{robot:.100}'", error)
        return error

    async def drive(
        self,
        robot: str,
        linear: float,
        angular: float,
        duration: float,
        report: Reporter,
        lateral: float = 0.0,
    ) -> str:
        """See `DrivenRobots`."""
        request = wire.Drive(
            id=self.new_id("goal"),
            robot=robot,
            linear=linear,
            angular=angular,
            duration=duration,
            lateral=lateral,
        )
        return await self.start(wire.DRIVE, request, report)

    async def follow_path(
        self, robot: str, points: Sequence[Point], speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        """See `PathRobots`."""
        path = tuple(Position3D(point.x, point.y) for point in points)
        request = wire.FollowPath(id=self.new_id("goal"), robot=robot, points=path, speed=speed, repeat=repeat)
        return await self.start(wire.FOLLOW_PATH, request, report)

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """See `VelocityCommands`. A topic without the name of a robot belongs to the first driven robot."""
        robot, _, name = topic.strip("/").rpartition("/")
        if name != CMD_VEL:
            raise BackendRefused(
                f"unknown topic '{topic}' of {self.name}; expected /{CMD_VEL} for its first driven robot, or "
                f"/ROBOT/{CMD_VEL}",
                wire.Result.NOT_FOUND,
            )
        await self.ask(wire.CMD_VEL, wire.CmdVel(robot=robot, twist=twist_message(velocity)))

    # ------------------------------------------------------------ arms

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

    async def take_posture(self, robot: str, posture: str, options: MotionOptions, report: Reporter) -> str:
        """See `Postures`."""
        request = wire.TakePosture(id=self.new_id("goal"), robot=robot, posture=posture, **_motion(options))
        return await self.start(wire.TAKE_POSTURE, request, report)

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
