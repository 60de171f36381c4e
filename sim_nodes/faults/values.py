"""Measuring faults of values: noise, bias, beams that see nothing.

Errors are told from the values of a sound sensor in the same tick. What other faults of the same sensor do to them
is allowed for: of a noisy value beyond the sensor's limits nothing is left, so that noise also loses beams, and
what is left of it has a smaller deviation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, assert_never

import numpy as np

from seoro.bridges.wire import BeamLoss, Bias, DeadBeams, DeadSector, GaussianNoise, Quantity, SensorFault
from sim_nodes.faults.check import Observation, Pairing, SensorCheck
from sim_nodes.faults.normal import Truncated, truncated
from sim_nodes.faults.tally import VALUES, Tally
from sim_nodes.geometry import Array
from sim_nodes.sensors.beams import dead_beams, lost_beams
from sim_nodes.sensors.sensor import Sensor

UNITS = {
    Quantity.LENGTH: "m",
    Quantity.ANGLE: "rad",
    Quantity.ACCELERATION: "m/s^2",
    Quantity.ANGULAR_RATE: "rad/s",
    Quantity.BRIGHTNESS: "of the brightest",
}
TINY = 1e-12  # stands for a deviation of zero where one divides by it
SCANS = 3  # with dead beams


class Errors:
    """The errors of one quantity in a sample, and what the faults lead one to expect of them.

    Args:
        sensor: The sensor.
        quantity: The quantity.
        faults: The faults that lie on the sensor.
        truth: Values of a sound sensor, shape (n,).
        values: Those that have arrived.
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
            self.found = (self.found + math.pi) % (2.0 * math.pi) - math.pi
        self._limits = sensor.limits
        self.left = self._left(truth[both])

    def _left(self, truth: Array) -> Truncated:
        """What is left of normal errors about values."""
        scale = max(self.deviation, TINY)
        low, high = (limit - truth - self.offset for limit in self._limits)
        return truncated(low / scale, high / scale)

    def share_within_limits(self, truth: Array) -> Array:
        """The probabilities that values stay within the limits of the sensor."""
        return self._left(truth).share


class NoiseCheck(SensorCheck):
    """Whether errors have the deviation of a noise."""

    STATE = ("_pairing", "_sums", "_squares")

    def __init__(self, fault: GaussianNoise, sensor: Sensor[Any]) -> None:
        self._fault = fault
        self._sensor = sensor
        self._pairing: Pairing[Any] = Pairing()
        noisy = [quantity for quantity, std in fault.deviation.items() if std > 0.0]
        self._sums = {quantity: Tally(VALUES) for quantity in noisy}
        self._squares = {quantity: Tally(VALUES) for quantity in noisy}

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        truth, values = self._sensor.values(pair.truth), self._sensor.values(pair.data)
        for quantity, tally in self._squares.items():
            errors = Errors(self._sensor, quantity, seen.faults, truth[quantity], values[quantity])
            scaled = (errors.found - errors.offset) / self._fault.deviation[quantity]
            left = errors.left
            variance = float((left.second - left.first**2).sum())
            self._sums[quantity].add(len(scaled), float(scaled.sum()), float(left.first.sum()), 0.0, variance)
            variance = float((left.fourth - left.second**2).sum())
            tally.add(len(scaled), float((scaled**2).sum()), float(left.second.sum()), 0.0, variance)

    @property
    def holds(self) -> bool:
        """Whether the deviations are those of the fault, about no other mean than there would be without it."""
        return all(self._squares[each].holds and self._sums[each].fits for each in self._squares)

    def figures(self) -> str:
        """The deviations."""
        return "; ".join(self._deviation(quantity, tally) for quantity, tally in self._squares.items())

    def _deviation(self, quantity: Quantity, tally: Tally) -> str:
        std, unit = self._fault.deviation[quantity], UNITS[quantity]
        if tally.count == 0:
            return f"no value of {quantity} to compare has arrived"
        found, expected = (std * math.sqrt(total / tally.count) for total in (tally.found, tally.expected))
        return (
            f"the errors of {tally.count} values of {quantity} have a standard deviation of {found:.4g} {unit}, "
            f"expected were {expected:.4g} {unit}"
        )


class BiasCheck(SensorCheck):
    """Whether errors have the mean of a bias."""

    STATE = ("_pairing", "_sums")

    def __init__(self, fault: Bias, sensor: Sensor[Any]) -> None:
        self._sensor = sensor
        self._pairing: Pairing[Any] = Pairing()
        self._sums = {quantity: Tally(VALUES) for quantity, offset in fault.offset.items() if offset != 0.0}

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        truth, values = self._sensor.values(pair.truth), self._sensor.values(pair.data)
        for quantity, tally in self._sums.items():
            errors = Errors(self._sensor, quantity, seen.faults, truth[quantity], values[quantity])
            left, count = errors.left, len(errors.found)
            expected = count * errors.offset + errors.deviation * float(left.first.sum())
            variance = errors.deviation**2 * float((left.second - left.first**2).sum())
            tally.add(count, float(errors.found.sum()), expected, expected - count * errors.offset, variance)

    @property
    def holds(self) -> bool:
        """Whether the means are those of the fault."""
        return all(tally.holds for tally in self._sums.values())

    def figures(self) -> str:
        """The means."""
        return "; ".join(self._mean(quantity, tally) for quantity, tally in self._sums.items())

    def _mean(self, quantity: Quantity, tally: Tally) -> str:
        unit = UNITS[quantity]
        if tally.count == 0:
            return f"no value of {quantity} to compare has arrived"
        found, expected = tally.found / tally.count, tally.expected / tally.count
        return (
            f"the errors of {tally.count} values of {quantity} have a mean of {found:.4g} {unit}, "
            f"expected were {expected:.4g} {unit}"
        )


class BeamLossCheck(SensorCheck):
    """Whether the share of beams that see nothing, though they should, is that of a fault."""

    STATE = ("_pairing", "_lost")

    def __init__(self, fault: BeamLoss, sensor: Sensor[Any]) -> None:
        self._sensor = sensor
        self._pairing: Pairing[Any] = Pairing()
        beams = len(sensor.bearings)
        self._share = lost_beams(fault.share, beams) / beams
        self._lost = Tally(VALUES)

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        truth = self._sensor.values(pair.truth)[Quantity.LENGTH]
        values = self._sensor.values(pair.data)[Quantity.LENGTH]
        alive = np.isfinite(truth)
        for fault in seen.faults.values():
            if isinstance(fault, DeadSector | DeadBeams):
                alive[dead_beams(fault, self._sensor.bearings)] = False
        errors = Errors(self._sensor, Quantity.LENGTH, seen.faults, truth, values)
        seen_anyway = errors.share_within_limits(truth[alive])
        losses = 1.0 - (1.0 - self._share) * seen_anyway
        self._lost.add(
            int(alive.sum()),
            float(np.isinf(values[alive]).sum()),
            float(losses.sum()),
            float((1.0 - seen_anyway).sum()),
            float((losses * (1.0 - losses)).sum()),
        )

    @property
    def holds(self) -> bool:
        """Whether the share is that of the fault."""
        return self._lost.holds

    def figures(self) -> str:
        """The share."""
        lost = self._lost
        if lost.count == 0:
            return "no beam that hits anything has arrived"
        return (
            f"of {lost.count} beams that hit something {lost.found / lost.count:.3f} were lost, "
            f"expected were {lost.expected / lost.count:.3f}"
        )


class DeadBeamsCheck(SensorCheck):
    """Whether beams see nothing that should, and others do."""

    STATE = ("_pairing", "_scans", "_blind", "_sighted")

    def __init__(self, fault: DeadSector | DeadBeams, sensor: Sensor[Any]) -> None:
        self._sensor = sensor
        self._pairing: Pairing[Any] = Pairing()
        self._dead = dead_beams(fault, sensor.bearings)
        self._scans = 0  # in a row in which they saw nothing
        self._blind = 0  # beams that saw nothing in those, but should have
        self._sighted = 0  # beams in the last scan that saw something, but should not have

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        truth = self._sensor.values(pair.truth)[Quantity.LENGTH][self._dead]
        values = self._sensor.values(pair.data)[Quantity.LENGTH][self._dead]
        self._sighted = int(np.isfinite(values).sum())
        if self._sighted:
            self._scans = self._blind = 0
        else:
            self._scans += 1
            self._blind += int(np.isfinite(truth).sum())

    @property
    def holds(self) -> bool:
        """Whether they do not."""
        return self._scans >= SCANS and self._blind > 0

    def figures(self) -> str:
        """How many."""
        count = len(self._dead)
        if self._sighted:
            return f"{self._sighted} of the {count} beams still see something"
        return (
            f"in {self._scans} scans none of the {count} beams saw anything, "
            f"and {self._blind} times one would have"
        )


ValueFault = GaussianNoise | Bias | BeamLoss | DeadSector | DeadBeams


def value_check(fault: ValueFault, sensor: Sensor[Any]) -> SensorCheck:
    """The measurement of a fault of values."""
    match fault:
        case GaussianNoise():
            return NoiseCheck(fault, sensor)
        case Bias():
            return BiasCheck(fault, sensor)
        case BeamLoss():
            return BeamLossCheck(fault, sensor)
        case DeadSector() | DeadBeams():
            return DeadBeamsCheck(fault, sensor)
        case _:
            assert_never(fault)
