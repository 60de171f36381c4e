"""Localised robots; see `LocalisedRobots`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.bridges.sim.rules import check_deviation
from seoro.runtime.contracts.backends import Reporter


class LocalisationRequests(Requests):
    """The capability `LocalisedRobots` of a node."""

    async def reinitialize_global_localization(self, robot: str) -> None:
        """See `LocalisedRobots`."""
        await self.ask(wire.REINITIALIZE_GLOBAL_LOCALIZATION, wire.RobotName(robot=robot))

    async def watch_localization(self, robot: str, report: Reporter) -> str:
        """See `LocalisedRobots`."""
        return await self.start(
            wire.WATCH_LOCALIZATION, wire.WatchLocalization(id=self.new_id("watch"), robot=robot), report
        )

    async def localization_error(self, robot: str) -> float | None:
        """See `LocalisedRobots`."""
        error = (await self.ask(wire.GET_LOCALIZATION, wire.RobotName(robot=robot))).error
        if error is not None:
            check_deviation(self.name, f"the error of the localisation of '{robot:.100}'", error)
        return error
