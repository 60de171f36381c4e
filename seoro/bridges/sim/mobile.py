"""Robots that drive; see `MobileRobots` for what the methods do."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.sim.messages import pose_message, vector_message
from seoro.bridges.sim.requests import Requests
from seoro.runtime.contracts import Pose3D, Position3D, Reporter

FEEDBACK_PERIOD = 1.0  # [s] between two notes of how far a robot is


class MobileRequests(Requests):
    """The capability `MobileRobots` of a node."""

    async def set_initial_pose(self, robot: str, pose: Pose3D) -> None:
        """See `MobileRobots`."""
        await self.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=robot, pose=pose_message(pose)))

    async def navigate(self, robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        """See `MobileRobots`."""
        goal = self.new_id("goal")
        request = wire.NavigateThroughPoses(
            id=goal,
            robot=robot,
            poses=tuple(map(pose_message, poses)),
            stop_at_each=stop_at_each,
            feedback_period=FEEDBACK_PERIOD,
        )
        self._reporters[goal] = report
        return await self.ask_reported(wire.NAVIGATE_THROUGH_POSES, request, goal)

    async def cancel_goal(self, goal: str) -> None:
        """See `MobileRobots`."""
        await self.forget(wire.CANCEL_GOAL, wire.CancelGoal(id=goal), goal)

    async def watch_proximity(
        self, robot: str, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """See `MobileRobots`."""
        watch = self.new_id("watch")
        request = wire.WatchProximity(
            id=watch,
            frame=frame,
            parent_frame=parent_frame,
            point=vector_message(point),
            threshold=threshold,
            robot=robot,
        )
        self._reporters[watch] = report
        return await self.ask_reported(wire.WATCH_PROXIMITY, request, watch)

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """See `MobileRobots`."""
        watch = self.new_id("watch")
        self._reporters[watch] = report
        request = wire.WatchDistance(id=watch, robot=robot, distance=distance)
        return await self.ask_reported(wire.WATCH_DISTANCE, request, watch)

    async def cancel_watch(self, watch: str) -> None:
        """See `MobileRobots`."""
        await self.forget(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)
