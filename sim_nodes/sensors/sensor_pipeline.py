"""The contract of sensors, and the pipeline of their samples to clients, with faults and data in transit.

Brightness has 256 levels; faults are declared as shares of the brightest. Values with errors are rounded to a
level, and clipped.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping
from typing import ClassVar, Generic, NamedTuple, TypeVar, assert_never

import numpy as np
from numpy.typing import NDArray

from seoro.bridges import wire
from seoro.bridges.wire import CameraFault, Delay, MessageLoss, Quantity, SensorFault
from sim_nodes.geometry import Array
from sim_nodes.noise import Noise
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK
from sim_nodes.views import Picture

ROUNDING = 1e-6  # [rad], [ticks]; 180 degrees of a scenario are not exactly pi

Beams = NDArray[np.intp]
BeamFault = wire.BeamLoss | wire.DeadSector | wire.DeadBeams


def lost_beams(share: float, count: int) -> int:
    """Return the number of beams for a share; 0.29 of 100 are 29, despite the rounding of floats."""
    return int(share * count + 1e-9)


def dead_beams(fault: wire.DeadSector | wire.DeadBeams, bearings: Array) -> Beams:
    """Return the indices of the beams that a fault makes blind in every scan."""
    match fault:
        case wire.DeadSector(start=start, end=end):
            turn = 2.0 * math.pi
            width = (end - start) % turn
            if width < ROUNDING:  # a sector that ends where it starts is the full circle
                width = turn
            return np.flatnonzero((bearings - start) % turn <= width)
        case wire.DeadBeams(beams=beams):
            return np.array(beams, dtype=np.intp)
        case _:
            assert_never(fault)


BRIGHTEST = 255

Mask = NDArray[np.bool_]
"""Pixels of an image, shape (height, width)."""


def brightness_faults(faults: Mapping[str, CameraFault]) -> tuple[float, float]:
    """Return the standard deviation and the offset of the errors of a camera's values [levels]."""
    noise, bias = faults.get("gaussian_noise"), faults.get("bias")
    deviation = noise.deviation.get(Quantity.BRIGHTNESS, 0.0) if isinstance(noise, wire.GaussianNoise) else 0.0
    offset = bias.offset.get(Quantity.BRIGHTNESS, 0.0) if isinstance(bias, wire.Bias) else 0.0
    return deviation * BRIGHTEST, offset * BRIGHTEST


def with_errors(picture: Picture, deviation: float, offset: float, random: np.random.Generator) -> Picture:
    """Return an image with an offset and normally distributed errors [levels]."""
    values = picture.astype(np.float32) + np.float32(offset)
    if deviation > 0.0:
        values += random.standard_normal(picture.shape, dtype=np.float32) * np.float32(deviation)
    levels: Picture = np.clip(np.rint(values), 0, BRIGHTEST).astype(np.uint8)
    return levels


def dead_pixels(
    fault: wire.DeadPixels | wire.DeadArea, height: int, width: int, random: np.random.Generator
) -> Mask:
    """Return the pixels that a fault makes black; `random` is the same for all images of a camera."""
    match fault:
        case wire.DeadPixels(share=share):
            mask = np.zeros(height * width, dtype=np.bool_)
            mask[random.choice(len(mask), lost_beams(share, len(mask)), replace=False)] = True
            return mask.reshape(height, width)
        case wire.DeadArea(left=left, top=top, right=right, bottom=bottom):
            # A pixel belongs to an area by its centre.
            across, down = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
            rows, columns = (down >= top) & (down <= bottom), (across >= left) & (across <= right)
            return rows[:, None] & columns[None, :]
        case _:
            assert_never(fault)


def within(ranges: Array, limits: tuple[float, float]) -> Array:
    """Return distances, with infinity for those out of limits [m]."""
    low, high = limits
    bounded: Array = np.where((ranges < low) | (ranges > high), np.inf, ranges)
    return bounded


def period_of(rate: float) -> int:
    """Return the ticks between two samples of a sensor with a rate [Hz]."""
    return max(1, round(1.0 / rate / TICK))


T = TypeVar("T")

Values = Mapping[Quantity, Array]


class Sensor(Stateful, ABC, Generic[T]):
    """A sensor with data of type T; the numbers in the data can be read and replaced by quantity.

    Attributes:
        period: Ticks between two samples.
        quantities: Quantities of `values`, in order.
        bearings: Directions of its beams, counterclockwise from straight ahead [rad], shape (n,).
        limits: Minimum and maximum of its numbers; values beyond are infinite in its data.
        sample_size: Memory of the data of a rendered sensor [bytes]; 0 for others.
    """

    period = 1
    quantities: tuple[Quantity, ...] = ()
    bearings: Array = np.zeros(0)
    limits = (-math.inf, math.inf)
    sample_size = 0

    def check(self) -> None:
        """Refuse use of a sensor that cannot work on this machine.

        Raises:
            RequestRefused: The message names the missing software.
        """

    @abstractmethod
    def read(self, tick: int) -> T:
        """Return the present data, with the errors of a sound sensor in a tick."""

    def values(self, data: T) -> Values:
        """Return the numbers in data; one for each beam, infinite without a return."""
        return {}

    def with_values(self, data: T, values: Values) -> T:
        """Return the data with other numbers."""
        return data


class Sample(NamedTuple, Generic[T]):
    """Data of a sensor and their tick."""

    tick: int
    data: T


F = TypeVar("F", bound=SensorFault | CameraFault)
D = TypeVar("D")
U = TypeVar("U")


class DelayLine(Stateful, Generic[F, D, U]):
    """A delay line with faults of type F, which delivers data of type D, and has items of type U in transit.

    Args:
        noise: Factory of noise sources by purpose.

    Attributes:
        faults: Faults by kind.
    """

    STATE: ClassVar[tuple[str, ...]] = ("faults", "_has_supply", "_frozen", "_in_transit")

    def __init__(self, noise: Callable[[str], Noise]) -> None:
        self.faults: dict[str, F] = {}
        self._has_supply = True
        self._frozen: D | None = None  # repeated by a freeze
        self._in_transit: deque[tuple[int, U]] = deque()  # with ticks, oldest first
        self._noise_of_messages = noise("message_loss")

    def add_fault(self, fault: F) -> None:
        """Add a fault; it replaces another of its kind."""
        self.faults[fault.kind] = fault
        self._start_over(fault.kind)

    def remove_fault(self, kind: str) -> None:
        """Remove the fault of a kind."""
        self.faults.pop(kind, None)
        self._start_over(kind)

    def set_power(self, on: bool) -> None:
        """Switch the power supply."""
        self._has_supply = on
        self._start_over("power_loss")

    def _start_over(self, kind: str) -> None:
        if kind == "freeze":
            self._frozen = None
        if kind in ("delay", "power_loss"):
            self._in_transit.clear()  # items in transit are lost

    @property
    def _has_power(self) -> bool:
        return self._has_supply and "power_loss" not in self.faults

    @property
    def _delay_ticks(self) -> int:
        """Minimum delay of all items [ticks]."""
        delay = self.faults.get("delay")
        return math.ceil(delay.time / TICK - ROUNDING) if isinstance(delay, Delay) else 0

    def _is_lost(self, tick: int) -> bool:
        """Whether an item sent in a tick is lost."""
        loss = self.faults.get("message_loss")
        return isinstance(loss, MessageLoss) and self._noise_of_messages.at(tick).random() < loss.probability


VALUE_FAULTS = (wire.BeamLoss, wire.DeadSector, wire.DeadBeams, wire.Bias, wire.GaussianNoise)


class SensorPipeline(DelayLine[wire.SensorFault, T, Sample[T]], Generic[T]):
    """The pipeline of a sensor's samples to clients.

    Args:
        sensor: The sensor.
        noise: Factory of noise sources by purpose.
        always: Whether the sensor is active without clients.

    Without clients, a sensor is inactive. This does not affect others: each draws its own random numbers.

    Attributes:
        in_use: Whether a client uses its samples.
        is_streamed: Whether an open stream uses its samples.
        truth: Sample of a sound sensor in the last tick; None if none was due.
        arrived: Sample that arrived in the last tick.
        latest: Last sample that arrived.
        count: Number of samples that arrived.
        arrival: Tick in which the last one arrived.
    """

    DERIVED = ("is_streamed",)
    STATE = (*DelayLine.STATE, "sensor", "in_use", "truth", "arrived", "latest", "count", "arrival")

    def __init__(self, sensor: Sensor[T], noise: Callable[[str], Noise], *, always: bool = False) -> None:
        super().__init__(noise)
        self.sensor = sensor
        self._always = always
        self.in_use = False
        self.is_streamed = False
        self.truth: Sample[T] | None = None
        self.arrived: Sample[T] | None = None
        self.latest: Sample[T] | None = None
        self.count = 0
        self.arrival: int | None = None
        self._noise = {quantity: noise(f"gaussian_noise/{quantity}") for quantity in sensor.quantities}
        self._noise_of_beams = noise("beam_loss")

    def activate(self) -> None:
        """Use the sensor, from the next sample on.

        Raises:
            RequestRefused: The sensor cannot work on this machine.
        """
        if not self.in_use:
            self.sensor.check()
        self.in_use = True

    @property
    def is_active(self) -> bool:
        """Whether it samples for a client or a stream."""
        return self.in_use or self.is_streamed

    def is_due(self, tick: int) -> bool:
        """Whether it samples the sensor in a tick."""
        return (self._always or self.in_use or self.is_streamed) and tick % self.sensor.period == 0

    def peek(self, tick: int) -> Sample[T] | None:
        """Return the latest sample, or of an inactive sensor the sample of a tick, without delay and loss.

        The pipeline does not change. None if nothing arrived, or the sensor has no power.
        """
        if self._always or self.is_active:
            return self.latest
        if not self._has_power:
            return None
        truth = Sample(tick, self.sensor.read(tick))
        return Sample(tick, self._distorted(truth))

    def update(self, tick: int, reading: T | None = None) -> None:
        """Sample the sensor if it is due, and deliver samples.

        Args:
            tick: The tick.
            reading: The reading of the sensor in this tick, if it was made already.
        """
        truth = self.truth = self.arrived = None
        if self.is_due(tick):
            truth = self.truth = Sample(tick, self.sensor.read(tick) if reading is None else reading)
            if not self.faults and self._has_supply and not self._in_transit:
                self._deliver(truth, tick)
                return
            self._send(truth)
        if self._in_transit and self._in_transit[0][0] <= tick:
            self._deliver(self._in_transit.popleft()[1], tick)

    def _deliver(self, sample: Sample[T], tick: int) -> None:
        self.latest = self.arrived = sample
        self.count, self.arrival = self.count + 1, tick

    def _send(self, truth: Sample[T]) -> None:
        """Send a sample through the faults."""
        if not self._has_power or self._is_lost(truth.tick):
            return
        data = self._distorted(truth)
        if "freeze" in self.faults:
            self._frozen = data = data if self._frozen is None else self._frozen
        self._in_transit.append((truth.tick + self._delay_ticks, Sample(truth.tick, data)))  # by arrival

    def _distorted(self, truth: Sample[T]) -> T:
        """Return the data of a sample with value faults."""
        faults = [fault for fault in self.faults.values() if isinstance(fault, VALUE_FAULTS)]
        if not faults:
            return truth.data
        values = {quantity: array.copy() for quantity, array in self.sensor.values(truth.data).items()}
        bearings = self.sensor.bearings
        for fault in faults:
            match fault:
                case wire.BeamLoss(share=share):
                    random, lost = self._noise_of_beams.at(truth.tick), lost_beams(share, len(bearings))
                    values[Quantity.LENGTH][random.choice(len(bearings), lost, replace=False)] = np.inf
                case wire.DeadSector() | wire.DeadBeams():
                    values[Quantity.LENGTH][dead_beams(fault, bearings)] = np.inf
                case wire.Bias(offset=offset):
                    for quantity, off in offset.items():
                        values[quantity] += off
                case wire.GaussianNoise(deviation=deviation):
                    for quantity, std in deviation.items():
                        errors = self._noise[quantity].at(truth.tick)
                        values[quantity] += errors.normal(0.0, std, len(values[quantity]))
        return self.sensor.with_values(truth.data, values)
