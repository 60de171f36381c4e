"""Robots driven by velocities; see `DrivenRobots`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.messages import twist_message
from seoro.bridges.sim.requests import Requests
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Velocity6D
from seoro.runtime.contracts.backends import Reporter

CMD_VEL = "cmd_vel"


class DrivingRequests(Requests):
    """The capability `DrivenRobots` of a node."""

    async def drive(self, robot: str, linear: float, angular: float, duration: float, report: Reporter) -> str:
        """See `DrivenRobots`."""
        request = wire.Drive(
            id=self.new_id("goal"), robot=robot, linear=linear, angular=angular, duration=duration
        )
        return await self.start(wire.DRIVE, request, report)

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """See `DrivenRobots`. A topic without the name of a robot belongs to the first driven robot."""
        robot, _, name = topic.strip("/").rpartition("/")
        if name != CMD_VEL:
            raise BackendRefused(
                f"unknown topic '{topic}' of {self.name}; expected /{CMD_VEL} for its first driven robot, or "
                f"/ROBOT/{CMD_VEL}",
                wire.Result.NOT_FOUND,
            )
        await self.ask(wire.CMD_VEL, wire.CmdVel(robot=robot, twist=twist_message(velocity)))
