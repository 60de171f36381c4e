"""Registry of the faults of a robot or of the free cameras: injects, checks and clears them."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from seoro.bridges.wire import Fault, Outcome
from sim_nodes.faults.check import Check, Checking
from sim_nodes.faults.devices import Device
from sim_nodes.goals import GoalResult
from sim_nodes.refusals import operation_failed, unknown
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK

LONGEST_LIMIT = 3600.0  # [s]


@dataclass
class _Measurement:
    """A running check of a fault."""

    device: str
    fault: Fault
    deadline: int  # tick
    checking: Checking

    @property
    def check(self) -> Check[Any]:
        return self.checking[0]


class FaultRegistry(Stateful):
    """The faults of a robot, or of the free cameras of a world.

    Args:
        robot: Name of the robot; empty for free cameras.
        devices: Devices by name; free cameras may be added and removed.
    """

    def __init__(self, robot: str, devices: Mapping[str, Device]) -> None:
        self._robot = robot
        self._devices = devices
        self._measured: dict[str, _Measurement] = {}  # by id
        self._ended: list[GoalResult] = []

    @property
    def devices(self) -> tuple[str, ...]:
        """Names of the devices."""
        return tuple(self._devices)

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of the running checks."""
        return tuple(self._measured)

    def save(self) -> State:
        """See `Stateful`; saves the running checks, which are not made with the robot."""
        self._abort_deleted()
        devices = {name: device.save() for name, device in self._devices.items()}
        measured = {
            identifier: (each.device, each.fault, each.deadline, each.check.save())
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
        for identifier, (device, fault, deadline, check) in state.values["measured"].items():
            measured = _Measurement(device, fault, deadline, self._devices[device].start_check(fault))
            measured.check.restore(check)
            self._measured[identifier] = measured

    def detach_goals(self, goals: Container[str]) -> None:
        """Stop reporting the checks with some ids; their faults stay."""
        self._measured = {each: measured for each, measured in self._measured.items() if each not in goals}
        self._ended = [end for end in self._ended if end.id not in goals]

    def cancel_all(self) -> Iterator[GoalResult]:
        """Cancel all checks on a reset; yields their results."""
        for identifier in tuple(self._measured):
            del self._measured[identifier]
            yield GoalResult(identifier, Outcome.CANCELED, "everything was reset")

    def inject(self, identifier: str, device: str, fault: Fault, limit: float, tick: int) -> None:
        """Inject a fault and start to check its effect.

        Args:
            identifier: Id of the check.
            device: Name of the device.
            fault: The fault; it replaces another of its kind.
            limit: Time limit of the check [s].
            tick: Present tick.

        Raises:
            RequestRefused: The device is unknown, or cannot have this fault.
        """
        if not 0.0 < limit <= LONGEST_LIMIT:
            raise operation_failed(
                f"invalid limit of {limit:g} s; expected more than 0 s, and at most {LONGEST_LIMIT:g} s"
            )
        found = self._device(device)
        found.check(fault)
        self._drop(device, fault.kind, "replaced by another fault of its kind")
        found.add_fault(fault)
        deadline = tick + math.ceil(limit / TICK)
        self._measured[identifier] = _Measurement(device, fault, deadline, found.start_check(fault))
        self._restart_checks(device)

    def clear(self, device: str, kind: str) -> None:
        """Clear the faults of a kind of a device; an empty name matches all.

        Raises:
            RequestRefused: The device is unknown.
        """
        for name in [device] if device else self.devices:
            found = self._device(name)
            for each in [kind] if kind else list(found.kinds):
                self._drop(name, each, "it was cleared")
                found.remove_fault(each)
            self._restart_checks(name)

    def cancel(self, identifier: str) -> Iterator[GoalResult]:
        """Cancel a check and clear its fault."""
        measured = self._measured.pop(identifier, None)
        if measured is not None:
            self.clear(measured.device, measured.fault.kind)
            yield GoalResult(identifier, Outcome.CANCELED)

    def tick(self, tick: int) -> Iterator[GoalResult]:
        """Update the checks with a tick; yields the results of checks that ended."""
        self._abort_deleted()
        for identifier, measured in tuple(self._measured.items()):
            check, observe = measured.checking
            check.observe(observe(tick))
            what = f"{measured.fault.kind} of {self._full_name(measured.device)}"
            if check.is_confirmed:
                del self._measured[identifier]
                yield GoalResult(identifier, Outcome.SUCCEEDED, f"{what} takes effect: {check.summary()}")
            elif tick >= measured.deadline:
                del self._measured[identifier]
                self.clear(measured.device, measured.fault.kind)
                message = f"no effect of {what} was confirmed: {check.summary()}"
                yield GoalResult(identifier, Outcome.ABORTED, message)
        ended, self._ended = self._ended, []
        yield from ended

    def _device(self, name: str) -> Device:
        if name in self._devices:
            return self._devices[name]
        if not self._robot:
            raise unknown(f"free camera {name!r}", "cameras", self._devices)
        raise unknown(f"device {name!r} of {self._robot}", "devices", self._devices)

    def _full_name(self, device: str) -> str:
        return f"{self._robot}/{device}" if self._robot else device

    def _abort_deleted(self) -> None:
        """Abort the checks of cameras that were deleted."""
        for identifier, measured in tuple(self._measured.items()):
            if measured.device not in self._devices:
                del self._measured[identifier]
                self._ended.append(GoalResult(identifier, Outcome.ABORTED, f"{measured.device} was deleted"))

    def _drop(self, device: str, kind: str, reason: str) -> None:
        """Stop the check of a fault; its result is reported in the next tick."""
        for identifier, measured in tuple(self._measured.items()):
            if (measured.device, measured.fault.kind) == (device, kind):
                del self._measured[identifier]
                self._ended.append(GoalResult(identifier, Outcome.CANCELED, reason))

    def _restart_checks(self, device: str) -> None:
        """Restart the checks of a device, because they allow for its other faults."""
        for measured in self._measured.values():
            if measured.device == device:
                measured.checking = self._devices[device].start_check(measured.fault)
