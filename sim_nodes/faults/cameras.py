"""Cameras as devices: those that robots carry, and those that are in the world by themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeGuard

from seoro.bridges.wire import BeamLoss, CameraFault, DeadBeams, DeadSector, Fault, WheelSlip
from sim_nodes.cameras import Cameras
from sim_nodes.faults.check import Check, Observation
from sim_nodes.faults.devices import Device, Source, cannot_have
from sim_nodes.faults.fitting import check_camera_fault
from sim_nodes.faults.pictures import arrival, camera_check, measure
from sim_nodes.sensors.camera_feed import CameraFeed


class CameraDevice(Source):
    """A camera; its faults are those of the way of its pictures, which `Cameras` has.

    Args:
        name: What it is called among the devices.
        cameras: The cameras of the world.
        camera: What it is called there.
    """

    def __init__(self, name: str, cameras: Cameras, camera: str) -> None:
        self._name = name
        self._cameras = cameras
        self._camera = camera

    @property
    def _feed(self) -> CameraFeed:
        return self._cameras.feed(self._camera)

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._feed.faults)

    def check(self, fault: Fault) -> None:
        """See `Device`; of a camera without pictures nothing could be measured."""
        if isinstance(fault, WheelSlip):
            raise cannot_have(self._name, fault, "it has no wheels")
        if isinstance(fault, BeamLoss | DeadSector | DeadBeams):
            raise cannot_have(self._name, fault, "it has no beams")
        check_camera_fault(fault, self._name, self._feed.lens)
        self._cameras.check_room(self._camera, fault)
        self._feed.sound()

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        assert _is_of_cameras(fault)
        self._feed.put(fault)

    def lift(self, kind: str) -> None:
        """See `Device`."""
        self._feed.lift(kind)

    def supply(self, on: bool) -> None:
        """See `Source`."""
        self._feed.supply(on)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        assert _is_of_cameras(fault)
        return camera_check(fault)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        measure(check, self._feed, tick)

    def observation(self, tick: int) -> Observation[Any]:
        """See `Source`."""
        return arrival(self._feed, tick)


def _is_of_cameras(fault: Fault) -> TypeGuard[CameraFault]:
    return not isinstance(fault, WheelSlip | BeamLoss | DeadSector | DeadBeams)


class FreeCameras(Mapping[str, Device]):
    """The cameras that are in the world by themselves, which come and go.

    Args:
        cameras: The cameras of the world.
    """

    def __init__(self, cameras: Cameras) -> None:
        self._cameras = cameras

    def __getitem__(self, name: str) -> Device:
        if name not in self._cameras.free:
            raise KeyError(name)
        return CameraDevice(name, self._cameras, name)

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._cameras.free))

    def __len__(self) -> int:
        return len(self._cameras.free)
