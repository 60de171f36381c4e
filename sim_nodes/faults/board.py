"""The faults of a robot, or of free cameras: injecting them, measuring that they take effect, clearing them."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass

from seoro.bridges.wire import Fault, Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.faults.check import Check
from sim_nodes.faults.devices import Device
from sim_nodes.goals import Ended
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK

LONGEST_LIMIT = 3600.0  # [s]


@dataclass
class _Measurement:
    """A fault that is being measured."""

    device: str
    fault: Fault
    check: Check
    deadline: int  # tick


@dataclass(frozen=True)
class _Saved:
    """A measurement as it is saved."""

    device: str
    fault: Fault
    check: State
    deadline: int


class FaultBoard(Stateful):
    """The faults of a robot, or of the free cameras of a world.

    Args:
        robot: Its name; empty for free cameras.
        devices: What of it can have faults, by their names; cameras may come and go.
    """

    def __init__(self, robot: str, devices: Mapping[str, Device]) -> None:
        self._robot = robot
        self._devices = devices
        self._measured: dict[str, _Measurement] = {}  # by id
        self._ended: list[Ended] = []

    @property
    def devices(self) -> tuple[str, ...]:
        """Names of what can have faults."""
        return tuple(self._devices)

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of what is being measured."""
        return tuple(self._measured)

    def save(self) -> State:
        """See `Stateful`; what is being measured was not made with the robot."""
        self._end_gone()
        devices = {name: device.save() for name, device in self._devices.items()}
        measured = {
            identifier: _Saved(each.device, each.fault, each.check.save(), each.deadline)
            for identifier, each in self._measured.items()
        }
        values = {"devices": devices, "measured": measured, "ended": list(self._ended)}
        return State(type(self).__name__, values)

    def restore(self, state: State) -> None:
        """See `Stateful`."""
        for name, device in self._devices.items():
            device.restore(state.values["devices"][name])
        self._ended = state.values["ended"]
        self._measured = {}
        for identifier, saved in state.values["measured"].items():
            check = self._devices[saved.device].begin(saved.fault)
            check.restore(saved.check)
            self._measured[identifier] = _Measurement(saved.device, saved.fault, check, saved.deadline)

    def disown(self, goals: Container[str]) -> None:
        """Measure no more for some ids; the faults stay."""
        self._measured = {each: measured for each, measured in self._measured.items() if each not in goals}
        self._ended = [end for end in self._ended if end.id not in goals]

    def abandon(self) -> Iterator[Ended]:
        """Stop measuring, since everything is put back; gives the measurements that ended."""
        for identifier in tuple(self._measured):
            del self._measured[identifier]
            yield Ended(identifier, Outcome.CANCELED, "everything was reset")

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
        found = self._device(device)
        found.check(fault)
        self._drop(device, fault.kind, "another fault of its kind took its place")
        found.put(fault)
        deadline = tick + math.ceil(limit / TICK)
        self._measured[identifier] = _Measurement(device, fault, found.begin(fault), deadline)
        self._begin_again(device)

    def clear(self, device: str, kind: str) -> None:
        """Clear the faults of one kind of one device; where a name is empty, all are meant.

        Raises:
            RequestRefused: There is no such device.
        """
        for name in [device] if device else self.devices:
            found = self._device(name)
            for each in [kind] if kind else list(found.kinds):
                self._drop(name, each, "it was cleared")
                found.lift(each)
            self._begin_again(name)

    def cancel(self, identifier: str) -> Iterator[Ended]:
        """Stop measuring, and clear the fault that was measured."""
        measured = self._measured.pop(identifier, None)
        if measured is not None:
            self.clear(measured.device, measured.fault.kind)
            yield Ended(identifier, Outcome.CANCELED)

    def tick(self, tick: int) -> Iterator[Ended]:
        """Measure what has happened in a tick; gives the measurements that ended."""
        self._end_gone()
        for identifier, measured in tuple(self._measured.items()):
            self._devices[measured.device].measure(measured.check, tick)
            what = f"{measured.fault.kind} of {self._called(measured.device)}"
            if measured.check.holds:
                del self._measured[identifier]
                yield Ended(identifier, Outcome.SUCCEEDED, f"{what} takes effect: {measured.check.figures()}")
            elif tick >= measured.deadline:
                del self._measured[identifier]
                self.clear(measured.device, measured.fault.kind)
                message = f"{what} was not found to take effect: {measured.check.figures()}"
                yield Ended(identifier, Outcome.ABORTED, message)
        ended, self._ended = self._ended, []
        yield from ended

    def _device(self, name: str) -> Device:
        if name in self._devices:
            return self._devices[name]
        what = (
            f"{self._robot} has no device {name!r}: it has"
            if self._robot
            else (f"there is no free camera {name!r}: there are")
        )
        raise RequestRefused(Result.NOT_FOUND, f"{what} {listed(self.devices)}")

    def _called(self, device: str) -> str:
        return f"{self._robot}/{device}" if self._robot else device

    def _end_gone(self) -> None:
        """Stop measuring cameras that were deleted."""
        for identifier, measured in tuple(self._measured.items()):
            if measured.device not in self._devices:
                del self._measured[identifier]
                self._ended.append(Ended(identifier, Outcome.ABORTED, f"{measured.device} was deleted"))

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
                measured.check = self._devices[device].begin(measured.fault)
