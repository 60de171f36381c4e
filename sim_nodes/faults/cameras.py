"""Cameras as devices with faults: mounted and free ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from seoro.bridges.wire import CameraFault, Fault
from sim_nodes.cameras import Cameras
from sim_nodes.faults.check import Checking, Observation
from sim_nodes.faults.devices import Device, Source, cannot_have
from sim_nodes.faults.image_checks import arrival, camera_check
from sim_nodes.faults.validation import check_camera_fault
from sim_nodes.sensors.camera_pipeline import CameraPipeline


class CameraDevice(Source):
    """A camera. Its faults act in its `CameraPipeline`, which `Cameras` owns.

    Args:
        name: Name of the device.
        cameras: The cameras of the world.
        camera: Name of the camera in `cameras`.
    """

    def __init__(self, name: str, cameras: Cameras, camera: str) -> None:
        self._name = name
        self._cameras = cameras
        self._camera = camera

    @property
    def _pipeline(self) -> CameraPipeline:
        return self._cameras.pipeline(self._camera)

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._pipeline.faults)

    def check(self, fault: Fault) -> None:
        """See `Device`; refuses faults of cameras that do not render, because no check is possible."""
        if not isinstance(fault, CameraFault):
            raise cannot_have(self._name, fault)
        check_camera_fault(fault, self._name, self._pipeline.lens)
        self._cameras.check_memory(self._camera, fault)
        self._pipeline.true_picture()

    def add_fault(self, fault: Fault) -> None:
        """See `Device`."""
        assert isinstance(fault, CameraFault)
        self._pipeline.add_fault(fault)

    def remove_fault(self, kind: str) -> None:
        """See `Device`."""
        self._pipeline.remove_fault(kind)

    def set_power(self, on: bool) -> None:
        """See `Source`."""
        self._pipeline.set_power(on)

    def start_check(self, fault: Fault) -> Checking:
        """See `Device`."""
        assert isinstance(fault, CameraFault)
        return camera_check(fault, self._pipeline)

    def observation(self, tick: int) -> Observation[Any]:
        """See `Source`."""
        return arrival(self._pipeline, tick)


class FreeCameras(Mapping[str, Device]):
    """The free cameras of a world as devices; they may be added and removed.

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
