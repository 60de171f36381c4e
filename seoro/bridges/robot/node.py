"""Robots behind a bridge as a backend: which actors live in them, the beginning and the end of a run."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.robot.holding import HoldingRequests
from seoro.bridges.sim.arms import ArmRequests
from seoro.bridges.sim.driving import DrivingRequests
from seoro.bridges.sim.localisation import LocalisationRequests
from seoro.bridges.sim.mobile import MobileRequests
from seoro.bridges.sim.requests import NodeAddress
from seoro.runtime.contracts import Happened, Lost

STOP_TIMEOUT = 5.0  # [s]; a bridge gives its robots less


class RobotNode(MobileRequests, LocalisationRequests, DrivingRequests, ArmRequests, HoldingRequests):
    """Robots behind a bridge that has been found, and that are held.

    No actor lives there by itself: where a robot moves in the real world, somebody has to have said which it is.

    Args:
        address: How the bridge is reached.
        holder: Who holds the robots.
        features: What the bridge said of itself when they were taken.
    """

    def __init__(self, address: NodeAddress, holder: wire.Holder, features: wire.RobotFeatures) -> None:
        super().__init__(address, holder, features.number)
        self._robots = {robot.name: robot for robot in features.robots}

    @property
    def robots(self) -> Sequence[wire.RobotInfo]:
        """The robots that there are."""
        return tuple(self._robots.values())

    def senses_contacts(self, robot: str) -> bool:
        """See `ContactSensing`."""
        return robot in self._robots and self._robots[robot].senses_contacts

    def home_of(self, actor: str, types: Sequence[str]) -> str | None:
        """None: see above."""
        return None

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Remember whom to tell of what happens, and of the end of the bridge."""
        self._happened, self._lost = happened, lost
        if self._loss is not None:
            lost(self._loss)

    async def end_run(self) -> None:
        """Make every robot stand still, and tell what came of goals that nobody has waited for."""
        for robot in self._robots:
            await self.ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot), STOP_TIMEOUT)
        await self.catch_up()
