"""Checks of faults of values: noise, bias, and blind beams.

Errors are relative to the values of a sound sensor in the same tick. Effects of other faults of the same sensor
are allowed for. Values beyond the sensor's limits are lost, so noise also loses beams and the remaining errors
have a smaller deviation.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

import numpy as np

from seoro.bridges.wire import BeamLoss, Bias, DeadBeams, DeadSector, GaussianNoise, Quantity, SensorFault
from sim_nodes.faults.checks import Observation, Pairing, SensorCheck
from sim_nodes.faults.statistics import VALUES, Tally, Truncated, truncated
from sim_nodes.geometry import Array, wrap
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, dead_beams, lost_beams

UNITS = {
    Quantity.LENGTH: "m",
    Quantity.ANGLE: "rad",
    Quantity.ACCELERATION: "m/s^2",
    Quantity.ANGULAR_RATE: "rad/s",
    Quantity.FORCE: "N",
    Quantity.TORQUE: "N m",
}
TINY = 1e-12  # replaces a zero deviation in divisions
SCANS = 3  # scans with dead beams


class Errors:
    """The errors of one quantity in a sample, and their expectations with the faults.

    Args:
        sensor: The sensor.
        quantity: The quantity.
        faults: Faults of the sensor by kind.
        truth: Values of a sound sensor, shape (n,).
        values: Values that arrived, shape (n,).
    """

    def __init__(
        self,
        sensor: Sensor[Any],
        quantity: Quantity,
        faults: Mapping[str, SensorFault],
        truth: Array,
        values: Array,
    ) -> None:
        noise, bias = faults.get("gaussian_noise"), faults.get("bias")
        self.deviation = noise.deviation.get(quantity, 0.0) if isinstance(noise, GaussianNoise) else 0.0
        self.offset = bias.offset.get(quantity, 0.0) if isinstance(bias, Bias) else 0.0
        both = np.isfinite(truth) & np.isfinite(values)
        self.found = values[both] - truth[both]
        if quantity is Quantity.ANGLE:
            self.found = wrap(self.found)
        self._limits = sensor.limits
        self.left = self._left(truth[both])

    def _left(self, truth: Array) -> Truncated:
        """Return the truncated distribution of errors about values."""
        scale = max(self.deviation, TINY)
        low, high = (limit - truth - self.offset for limit in self._limits)
        return truncated(low / scale, high / scale)

    def share_within_limits(self, truth: Array) -> Array:
        """Return the probabilities that values stay within the limits of the sensor."""
        return self._left(truth).share


class ValueCheck(SensorCheck):
    """A check that compares the values of received samples with the true ones.

    Args:
        sensor: The sensor.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_pairing",)

    def __init__(self, sensor: Sensor[Any]) -> None:
        self._sensor = sensor
        self._pairing: Pairing[Any] = Pairing()

    def observe(self, seen: Observation[Any]) -> None:
        """See `Check`."""
        pair = self._pairing.pair(seen)
        if pair is not None:
            truth, values = map(self._sensor.values, pair)
            self.compare(truth, values, seen.faults)

    @abstractmethod
    def compare(self, truth: Values, values: Values, faults: Mapping[str, SensorFault]) -> None:
        """Update with the true and the received values of a sample."""


class ErrorCheck(ValueCheck):
    """A check of a statistic of errors, by quantity.

    Args:
        sensor: The sensor.
        quantities: Quantities with errors.
    """

    def __init__(self, sensor: Sensor[Any], quantities: Iterable[Quantity]) -> None:
        super().__init__(sensor)
        self._tallies = {quantity: Tally(VALUES) for quantity in quantities}

    def compare(self, truth: Values, values: Values, faults: Mapping[str, SensorFault]) -> None:
        """See `ValueCheck`."""
        for quantity in self._tallies:
            self.count(quantity, Errors(self._sensor, quantity, faults, truth[quantity], values[quantity]))

    @abstractmethod
    def count(self, quantity: Quantity, errors: Errors) -> None:
        """Add the errors of a quantity in a sample."""

    def figures(self, statistic: str, figure: Callable[[Quantity, float], float]) -> str:
        """Return a text with a statistic of each quantity; `figure` computes it from the mean of the tally."""
        return "; ".join(self._figure(quantity, statistic, figure) for quantity in self._tallies)

    def _figure(self, quantity: Quantity, statistic: str, figure: Callable[[Quantity, float], float]) -> str:
        tally, unit = self._tallies[quantity], UNITS[quantity]
        if tally.count == 0:
            return f"no comparable value of {quantity} has arrived"
        found, expected = (figure(quantity, total / tally.count) for total in (tally.found, tally.expected))
        return (
            f"the errors of {tally.count} values of {quantity} have a {statistic} of {found:.4g} {unit}, "
            f"expected {expected:.4g} {unit}"
        )


class NoiseCheck(ErrorCheck):
    """Checks that errors have the deviation of a noise."""

    STATE = (*ValueCheck.STATE, "_tallies", "_sums")

    def __init__(self, fault: GaussianNoise, sensor: Sensor[Any]) -> None:
        super().__init__(sensor, [quantity for quantity, std in fault.deviation.items() if std > 0.0])
        self._deviation = fault.deviation
        self._sums = {quantity: Tally(VALUES) for quantity in self._tallies}

    def count(self, quantity: Quantity, errors: Errors) -> None:
        """See `ErrorCheck`."""
        scaled = (errors.found - errors.offset) / self._deviation[quantity]
        left = errors.left
        variance = float((left.second - left.first**2).sum())
        self._sums[quantity].add(len(scaled), float(scaled.sum()), float(left.first.sum()), 0.0, variance)
        variance = float((left.fourth - left.second**2).sum())
        squares = float((scaled**2).sum())
        self._tallies[quantity].add(len(scaled), squares, float(left.second.sum()), 0.0, variance)

    @property
    def is_confirmed(self) -> bool:
        """Whether the deviations fit the fault, and the means fit a sensor without it."""
        return all(self._tallies[each].is_confirmed and self._sums[each].fits for each in self._tallies)

    def summary(self) -> str:
        """Return a text with the deviations."""
        return self.figures("standard deviation", lambda each, mean: self._deviation[each] * math.sqrt(mean))


class BiasCheck(ErrorCheck):
    """Checks that errors have the mean of a bias."""

    STATE = (*ValueCheck.STATE, "_tallies")

    def __init__(self, fault: Bias, sensor: Sensor[Any]) -> None:
        super().__init__(sensor, [quantity for quantity, offset in fault.offset.items() if offset != 0.0])

    def count(self, quantity: Quantity, errors: Errors) -> None:
        """See `ErrorCheck`."""
        left, count = errors.left, len(errors.found)
        expected = count * errors.offset + errors.deviation * float(left.first.sum())
        variance = errors.deviation**2 * float((left.second - left.first**2).sum())
        sound = expected - count * errors.offset
        self._tallies[quantity].add(count, float(errors.found.sum()), expected, sound, variance)

    @property
    def is_confirmed(self) -> bool:
        """Whether the means fit the fault."""
        return all(tally.is_confirmed for tally in self._tallies.values())

    def summary(self) -> str:
        """Return a text with the means."""
        return self.figures("mean", lambda _, mean: mean)


class BeamLossCheck(ValueCheck):
    """Checks that the share of beams without a return, which should have one, is that of a fault."""

    STATE = (*ValueCheck.STATE, "_lost")

    def __init__(self, fault: BeamLoss, sensor: Sensor[Any]) -> None:
        super().__init__(sensor)
        beams = len(sensor.bearings)
        self._share = lost_beams(fault.share, beams) / beams
        self._lost = Tally(VALUES)

    def compare(self, truth: Values, values: Values, faults: Mapping[str, SensorFault]) -> None:
        """See `ValueCheck`."""
        lengths, found = truth[Quantity.LENGTH], values[Quantity.LENGTH]
        alive = np.isfinite(lengths)
        for fault in faults.values():
            if isinstance(fault, DeadSector | DeadBeams):
                alive[dead_beams(fault, self._sensor.bearings)] = False
        errors = Errors(self._sensor, Quantity.LENGTH, faults, lengths, found)
        within_limits = errors.share_within_limits(lengths[alive])
        losses = 1.0 - (1.0 - self._share) * within_limits
        self._lost.add(
            int(alive.sum()),
            float(np.isinf(found[alive]).sum()),
            float(losses.sum()),
            float((1.0 - within_limits).sum()),
            float((losses * (1.0 - losses)).sum()),
        )

    @property
    def is_confirmed(self) -> bool:
        """Whether the share fits the fault."""
        return self._lost.is_confirmed

    def summary(self) -> str:
        """Return a text with the share."""
        lost = self._lost
        if lost.count == 0:
            return "no beam that hits anything has arrived"
        return (
            f"of {lost.count} beams that hit something {lost.found / lost.count:.3f} were lost, "
            f"expected {lost.expected / lost.count:.3f}"
        )


class DeadBeamsCheck(ValueCheck):
    """Checks that dead beams have no return where they should, and that other beams have one."""

    STATE = (*ValueCheck.STATE, "_scans", "_blind", "_sighted")

    def __init__(self, fault: DeadSector | DeadBeams, sensor: Sensor[Any]) -> None:
        super().__init__(sensor)
        self._dead = dead_beams(fault, sensor.bearings)
        self._scans = 0  # in a row without a return of these beams
        self._blind = 0  # lost returns in those scans
        self._sighted = 0  # beams of the last scan with a return that should have none

    def compare(self, truth: Values, values: Values, faults: Mapping[str, SensorFault]) -> None:
        """See `ValueCheck`."""
        lengths, found = (each[Quantity.LENGTH][self._dead] for each in (truth, values))
        self._sighted = int(np.isfinite(found).sum())
        if self._sighted:
            self._scans = self._blind = 0
        else:
            self._scans += 1
            self._blind += int(np.isfinite(lengths).sum())

    @property
    def is_confirmed(self) -> bool:
        """Whether the dead beams are confirmed."""
        return self._scans >= SCANS and self._blind > 0

    def summary(self) -> str:
        """Return a text with the numbers."""
        count = len(self._dead)
        if self._sighted:
            return f"{self._sighted} of the {count} beams still see something"
        return (
            f"in {self._scans} scans none of the {count} beams saw anything, "
            f"and {self._blind} times one would have"
        )
