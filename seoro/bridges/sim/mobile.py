"""Mobile robots; see `MobileRobots`."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import Reporter

FEEDBACK_PERIOD = 1.0  # [s] between two reports of progress


class MobileRequests(Requests):
    """The capability `MobileRobots` of a node."""

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

    async def cancel_goal(self, goal: str) -> None:
        """See `MobileRobots`."""
        await self.cancel_report(wire.CANCEL_GOAL, wire.CancelGoal(id=goal), goal)

    async def watch_proximity(
        self, robot: str, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """See `MobileRobots`."""
        request = wire.WatchProximity(
            id=self.new_id("watch"),
            frame=frame,
            parent_frame=parent_frame,
            point=point,
            threshold=threshold,
            robot=robot,
        )
        return await self.start(wire.WATCH_PROXIMITY, request, report)

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """See `MobileRobots`."""
        request = wire.WatchDistance(id=self.new_id("watch"), robot=robot, distance=distance)
        return await self.start(wire.WATCH_DISTANCE, request, report)

    async def cancel_watch(self, watch: str) -> None:
        """See `MobileRobots`."""
        await self.cancel_report(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)
