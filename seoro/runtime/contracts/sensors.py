"""Contracts of backends whose robots have sensors and cameras, and of backends that inject faults into these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.robotics.faults import Fault
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import Reporter


@runtime_checkable
class Sensors(Protocol):
    """Sensors of robots. `robot` is the name from `assign_robot`; `sensor` is a sensor of that robot.

    Watches see the samples as they arrive, with injected faults. Each returns the watch's id.
    """

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """Report the arrival of the next sample."""

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """Report when an entity presses a zone of the bumper; empty names match any."""

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """Report when a ranging sensor measures less than `distance` [m] between two bearings [rad]."""

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """Report after `duration` [s] whether the rate of samples was within bounds [1/s]."""

    async def cancel_sensor_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class ForceSensing(Protocol):
    """Force-torque sensors of robots; see `Sensors`."""

    async def watch_force(self, robot: str, sensor: str, force: float, report: Reporter) -> str:
        """Report when the force that a force-torque sensor measures exceeds `force` [N]."""

    async def cancel_sensor_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class SightSensing(Protocol):
    """Segmentation sensors of robots; see `Sensors`."""

    async def watch_sight(self, robot: str, sensor: str, entity: str, share: float, report: Reporter) -> str:
        """Report when a segmentation sensor sees an entity on at least `share` of its picture."""

    async def cancel_sensor_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class Faults(Protocol):
    """Faults of sensors, cameras and motors.

    `robot` is the name from `assign_robot`, `device` a device of that robot. Free cameras belong to no robot:
    pass an empty robot name.
    """

    def devices(self) -> Mapping[str, Sequence[str]]:
        """Return the device names of each robot, in their order."""

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """Inject a fault, replacing another of its kind, and measure its effect.

        The measurement is reported as success, or as abortion if no effect was measured within `limit` [s]; the
        fault is then cleared. Return the id of the measurement.
        """

    async def cancel_fault(self, measurement: str) -> None:
        """Clear a fault whose effect is being measured. Finished measurements are ignored."""

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """Clear the faults of a device (all devices if empty), of one kind if `fault` is given."""


class Image(Value):
    """A picture as PNG, with its time [s] and size [pixels]."""

    time: float
    width: int
    height: int
    png: bytes


@runtime_checkable
class Cameras(Protocol):
    """Cameras. Free cameras can be moved; cameras of a robot are named `robot/camera`."""

    async def spawn_camera(self, name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        """Spawn a free camera that looks along the x axis of its pose; return its actual name.

        Args:
            name: Requested name.
            pose: Its pose in the map.
            fov: Vertical field of view [rad].
            width: Width of its pictures [pixels].
            height: Height of its pictures [pixels].
        """

    async def cameras(self) -> tuple[str, ...]:
        """Return the names of all cameras."""

    async def place_camera(self, name: str, pose: Pose3D) -> None:
        """Set the pose of a free camera; it stops following."""

    async def aim_camera(self, name: str, target: Position3D) -> None:
        """Turn a free camera in place so that a point is in the middle of its pictures."""

    async def follow_entity(self, name: str, entity: str, offset: Position3D) -> None:
        """Make a free camera follow an entity at an offset along the axes of the map, and look at it."""

    async def delete_camera(self, name: str) -> None:
        """Delete a spawned camera."""

    async def take_picture(self, name: str) -> Image:
        """Take a picture, subject to injected faults. Refused if a fault suppresses the picture."""
