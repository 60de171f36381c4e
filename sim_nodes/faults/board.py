"""The faults of one robot: injecting them, measuring that they take effect, clearing them."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, assert_never

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
    DeadSector,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    Outcome,
    PowerLoss,
    Result,
    SensorFault,
    WheelSlip,
)
from sim_nodes.faults.arrivals import arrival_check
from sim_nodes.faults.check import Observation, SensorCheck
from sim_nodes.faults.fitting import check_fault
from sim_nodes.faults.values import value_check
from sim_nodes.goals import Ended
from sim_nodes.refusal import RequestRefused, listed
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK

LONGEST_LIMIT = 3600.0  # [s]


@dataclass
class _Measurement:
    """A fault that is being measured."""

    device: str
    fault: SensorFault
    check: SensorCheck
    deadline: int  # tick


@dataclass(frozen=True)
class _Saved:
    """A measurement as it is saved."""

    device: str
    fault: SensorFault
    check: State
    deadline: int


class FaultBoard(Stateful):
    """The faults of a robot.

    Args:
        robot: Its name.
        sensors: The ways of its sensors' samples, by the sensors' names.
    """

    def __init__(self, robot: str, sensors: Mapping[str, Feed[Any]]) -> None:
        self._robot = robot
        self._sensors = sensors
        self._measured: dict[str, _Measurement] = {}  # by id
        self._ended: list[Ended] = []

    @property
    def devices(self) -> tuple[str, ...]:
        """Names of what can have faults."""
        return tuple(self._sensors)

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of what is being measured."""
        return tuple(self._measured)

    def save(self) -> State:
        """See `Stateful`; what is being measured was not made with the robot."""
        measured = {
            identifier: _Saved(each.device, each.fault, each.check.save(), each.deadline)
            for identifier, each in self._measured.items()
        }
        return State(type(self).__name__, {"_measured": measured, "_ended": tuple(self._ended)})

    def restore(self, state: State) -> None:
        """See `Stateful`."""
        self._ended = list(state.values["_ended"])
        self._measured = {}
        for identifier, saved in state.values["_measured"].items():
            check = sensor_check(saved.fault, self._sensors[saved.device].sensor)
            check.restore(saved.check)
            self._measured[identifier] = _Measurement(saved.device, saved.fault, check, saved.deadline)

    def disown(self, goals: Container[str]) -> None:
        """Measure no more for some ids; the faults stay."""
        self._measured = {each: measured for each, measured in self._measured.items() if each not in goals}
        self._ended = [end for end in self._ended if end.id not in goals]

    def inject(self, identifier: str, device: str, fault: Fault, limit: float, tick: int) -> None:
        """Inject a fault and begin to measure it.

        Args:
            identifier: Of its measurement.
            device: What gets it.
            fault: The fault; it takes the place of another of its kind.
            limit: How long to measure [s].
            tick: The tick of now.

        Raises:
            RequestRefused: There is no such device, or it cannot have this fault.
        """
        if not 0.0 < limit <= LONGEST_LIMIT:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the limit is {limit:g} s: it has to be above 0 s, and {LONGEST_LIMIT:g} s at most",
            )
        feed = self._feed(device)
        if isinstance(fault, WheelSlip):
            raise RequestRefused(Result.OPERATION_FAILED, f"{device} has no wheels that could slip")
        check_fault(fault, device, feed.sensor)
        self._drop(device, fault.kind, "another fault of its kind took its place")
        feed.put(fault)
        feed.in_use = True
        self._measured[identifier] = _Measurement(
            device, fault, sensor_check(fault, feed.sensor), tick + math.ceil(limit / TICK)
        )
        self._begin_again(device)

    def clear(self, device: str, kind: str) -> None:
        """Clear the faults of one kind of one device; where a name is empty, all are meant.

        Raises:
            RequestRefused: There is no such device.
        """
        for name in [device] if device else self.devices:
            feed = self._feed(name)
            for each in [kind] if kind else list(feed.faults):
                self._drop(name, each, "it was cleared")
                feed.lift(each)
            self._begin_again(name)

    def cancel(self, identifier: str) -> Iterator[Ended]:
        """Stop measuring, and clear the fault that was measured."""
        measured = self._measured.pop(identifier, None)
        if measured is not None:
            self.clear(measured.device, measured.fault.kind)
            yield Ended(identifier, Outcome.CANCELED)

    def tick(self, tick: int) -> Iterator[Ended]:
        """Measure what has happened in a tick; gives the measurements that ended."""
        for identifier, measured in tuple(self._measured.items()):
            feed = self._sensors[measured.device]
            measured.check.observe(Observation(tick, feed.truth, feed.arrived, feed.faults))
            what = f"{measured.fault.kind} of {self._robot}/{measured.device}"
            if measured.check.holds:
                del self._measured[identifier]
                yield Ended(identifier, Outcome.SUCCEEDED, f"{what} takes effect: {measured.check.figures()}")
            elif tick >= measured.deadline:
                message = f"{what} was not found to take effect: {measured.check.figures()}"
                self.clear(measured.device, measured.fault.kind)
                yield Ended(identifier, Outcome.ABORTED, message)
        ended, self._ended = self._ended, []
        yield from ended

    def _feed(self, device: str) -> Feed[Any]:
        if device not in self._sensors:
            raise RequestRefused(
                Result.NOT_FOUND, f"{self._robot} has no device {device!r}: it has {listed(self.devices)}"
            )
        return self._sensors[device]

    def _drop(self, device: str, kind: str, why: str) -> None:
        """Stop measuring a fault of a device; its end is told in the next tick."""
        for identifier, measured in tuple(self._measured.items()):
            if (measured.device, measured.fault.kind) == (device, kind):
                del self._measured[identifier]
                self._ended.append(Ended(identifier, Outcome.CANCELED, why))

    def _begin_again(self, device: str) -> None:
        """Measure a device anew, since its other faults have to be allowed for."""
        for measured in self._measured.values():
            if measured.device == device:
                measured.check = sensor_check(measured.fault, self._sensors[device].sensor)


def sensor_check(fault: SensorFault, sensor: Sensor[Any]) -> SensorCheck:
    """The measurement of a fault of a sensor."""
    match fault:
        case GaussianNoise() | Bias() | BeamLoss() | DeadSector() | DeadBeams():
            return value_check(fault, sensor)
        case MessageLoss() | Freeze() | Delay() | PowerLoss():
            return arrival_check(fault, sensor)
        case _:
            assert_never(fault)
