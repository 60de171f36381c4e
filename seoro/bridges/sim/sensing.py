"""Force-torque and segmentation sensors of robots; see `ForceSensing` and `SightSensing`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.robots import RobotRequests
from seoro.runtime.contracts.backends import Reporter


class SensingRequests(RobotRequests):
    """The capabilities `ForceSensing` and `SightSensing`."""

    async def watch_force(self, robot: str, sensor: str, force: float, report: Reporter) -> str:
        """See `ForceSensing`."""
        request = wire.WatchForce(id=self.new_id("watch"), robot=robot, sensor=sensor, force=force)
        return await self.start(wire.WATCH_FORCE, request, report)

    async def watch_sight(self, robot: str, sensor: str, entity: str, share: float, report: Reporter) -> str:
        """See `SightSensing`."""
        request = wire.WatchSight(id=self.new_id("watch"), robot=robot, sensor=sensor, entity=entity, share=share)
        return await self.start(wire.WATCH_SIGHT, request, report)

    cancel_sensor_watch = RobotRequests.cancel_watch
