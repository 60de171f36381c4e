"""Devices that can have faults: common base classes, sensors, and mounted and free cameras."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, assert_never

from seoro.bridges import wire
from seoro.bridges.wire import CameraFault, Fault
from sim_nodes.cameras import Cameras
from sim_nodes.faults.checks import (
    Checking,
    DelayCheck,
    FreezeCheck,
    MessageLossCheck,
    Observation,
    SensorCheck,
    SilenceCheck,
    are_equal,
)
from sim_nodes.faults.image_checks import arrival, camera_check
from sim_nodes.faults.validation import cannot_have, check_camera_fault, check_fault
from sim_nodes.faults.value_checks import BeamLossCheck, BiasCheck, DeadBeamsCheck, NoiseCheck
from sim_nodes.sensors.camera_pipeline import CameraPipeline
from sim_nodes.sensors.sensor_pipeline import DelayLine, Sensor, SensorPipeline
from sim_nodes.stateful import Stateful


class Device(Stateful, ABC):
    """A device that can have one fault of each kind."""

    @property
    @abstractmethod
    def kinds(self) -> Sequence[str]:
        """Kinds of its faults."""

    @abstractmethod
    def check(self, fault: wire.Fault) -> None:
        """Refuse a fault that the device cannot have.

        Raises:
            RequestRefused: The message gives the reason.
        """

    @abstractmethod
    def add_fault(self, fault: wire.Fault) -> None:
        """Add a checked fault; it replaces another of its kind."""

    @abstractmethod
    def remove_fault(self, kind: str) -> None:
        """Remove the fault of a kind, if there is one."""

    @abstractmethod
    def start_check(self, fault: wire.Fault) -> Checking:
        """Return a new check of a fault of the device."""


class Source(Device):
    """A device that gives data while it has power; its faults act in its pipeline."""

    @property
    @abstractmethod
    def pipeline(self) -> DelayLine[Any, Any, Any]:
        """Pipeline of its data."""

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self.pipeline.faults)

    def add_fault(self, fault: wire.Fault) -> None:
        """See `Device`."""
        self.pipeline.add_fault(fault)

    def remove_fault(self, kind: str) -> None:
        """See `Device`."""
        self.pipeline.remove_fault(kind)

    def set_power(self, on: bool) -> None:
        """Switch the power supply."""
        self.pipeline.set_power(on)

    @abstractmethod
    def observation(self, tick: int) -> Observation[Any]:
        """Return the data of a tick."""


class SensorDevice(Source):
    """A sensor; its faults act in its pipeline.

    Args:
        name: Name of the device.
        pipeline: Pipeline of its samples.
    """

    def __init__(self, name: str, pipeline: SensorPipeline[Any]) -> None:
        self._name = name
        self._pipeline = pipeline

    @property
    def pipeline(self) -> SensorPipeline[Any]:
        """See `Source`."""
        return self._pipeline

    def check(self, fault: wire.Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, wire.SensorFault):
            raise cannot_have(self._name, fault)
        check_fault(fault, self._name, self.pipeline.sensor)

    def add_fault(self, fault: wire.Fault) -> None:
        """See `Device`; activates the sensor."""
        self.pipeline.activate()
        super().add_fault(fault)

    def set_power(self, on: bool) -> None:
        """See `Source`; activates the sensor."""
        super().set_power(on)
        self.pipeline.activate()

    def observation(self, tick: int) -> Observation[Any]:
        """See `Source`."""
        return Observation(tick, self.pipeline.truth, self.pipeline.arrived, self.pipeline.faults)

    def start_check(self, fault: wire.Fault) -> Checking:
        """See `Device`."""
        assert isinstance(fault, wire.SensorFault)
        return sensor_check(fault, self.pipeline.sensor), self.observation


def sensor_check(fault: wire.SensorFault, sensor: Sensor[Any], what: str = "samples") -> SensorCheck:
    """Return a check of a fault of a sensor; `what` is the word for samples."""
    match fault:
        case wire.GaussianNoise():
            return NoiseCheck(fault, sensor)
        case wire.Bias():
            return BiasCheck(fault, sensor)
        case wire.BeamLoss():
            return BeamLossCheck(fault, sensor)
        case wire.DeadSector() | wire.DeadBeams():
            return DeadBeamsCheck(fault, sensor)
        case wire.MessageLoss():
            return MessageLossCheck(fault, what)
        case wire.Freeze():
            return FreezeCheck(partial(are_equal, sensor), what)
        case wire.Delay():
            return DelayCheck(fault, what)
        case wire.PowerLoss():
            return SilenceCheck(what)
        case _:
            assert_never(fault)


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
    def pipeline(self) -> CameraPipeline:
        """See `Source`."""
        return self._cameras.pipeline(self._camera)

    def check(self, fault: Fault) -> None:
        """See `Device`; refuses faults of cameras that do not render, because no check is possible."""
        if not isinstance(fault, CameraFault):
            raise cannot_have(self._name, fault)
        check_camera_fault(fault, self._name, self.pipeline.lens)
        self._cameras.check_memory(self._camera, fault)
        self.pipeline.true_picture()

    def start_check(self, fault: Fault) -> Checking:
        """See `Device`."""
        assert isinstance(fault, CameraFault)
        return camera_check(fault, self.pipeline)

    def observation(self, tick: int) -> Observation[Any]:
        """See `Source`."""
        return arrival(self.pipeline, tick)


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
