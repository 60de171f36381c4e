"""Robots behind a bridge as a backend."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.robot.holding import HoldingRequests
from seoro.bridges.sim.arms import ArmRequests
from seoro.bridges.sim.driving import DrivingRequests
from seoro.bridges.sim.localisation import LocalisationRequests
from seoro.bridges.sim.mobile import MobileRequests
from seoro.bridges.sim.requests import NodeAddress

STOP_TIMEOUT = 5.0  # [s]; longer than that of bridges for their robots


class RobotNode(MobileRequests, LocalisationRequests, DrivingRequests, ArmRequests, HoldingRequests):
    """Held robots of a bridge.

    Actors are never assigned to real robots implicitly: the user names the robot of each actor.

    Args:
        address: Address of the bridge.
        holder: Holder of the robots.
        features: Features of the bridge at the acquisition.
    """

    def __init__(self, address: NodeAddress, holder: wire.Holder, features: wire.RobotFeatures) -> None:
        super().__init__(address, holder, features.number)
        self._robots = {robot.name: robot for robot in features.robots}

    @property
    def robots(self) -> Sequence[wire.RobotInfo]:
        """The held robots."""
        return tuple(self._robots.values())

    def senses_contacts(self, robot: str) -> bool:
        """See `ContactSensing`."""
        return robot in self._robots and self._robots[robot].senses_contacts

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return None, see above."""
        return None

    async def end_run(self) -> None:
        """Stop every robot, and report the remaining events."""
        for robot in self._robots:
            await self.ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot), STOP_TIMEOUT)
        await self.replay_events()
