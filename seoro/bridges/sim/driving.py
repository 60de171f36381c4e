"""Robots that are driven by velocities; see `DrivenRobots` for what the methods do."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.messages import twist_message
from seoro.bridges.sim.requests import Requests
from seoro.errors import BackendRefused
from seoro.runtime.contracts import Reporter, Velocity6D

CMD_VEL = "cmd_vel"


class DrivingRequests(Requests):
    """The capability `DrivenRobots` of a node."""

    async def drive(self, robot: str, linear: float, angular: float, duration: float, report: Reporter) -> str:
        """See `DrivenRobots`."""
        goal = self.new_id("goal")
        self._reporters[goal] = report
        request = wire.Drive(id=goal, robot=robot, linear=linear, angular=angular, duration=duration)
        return await self.ask_reported(wire.DRIVE, request, goal)

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """See `DrivenRobots`. A topic without a robot's name is the first robot's that drives."""
        robot, _, name = topic.strip("/").rpartition("/")
        if name != CMD_VEL:
            raise BackendRefused(
                f"{self.name} has no topic '{topic}' to publish on: there is /{CMD_VEL} for its first robot that "
                f"drives, and /ROBOT/{CMD_VEL} for each",
                wire.Result.NOT_FOUND,
            )
        await self.ask(wire.CMD_VEL, wire.CmdVel(robot=robot, twist=twist_message(velocity)))
