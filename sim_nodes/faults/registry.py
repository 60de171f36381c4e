"""Registry of the faults of a robot or of the free cameras, and loss of power of a whole robot."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping, Sequence

from seoro.bridges.wire import Fault, Outcome, PowerLoss
from seoro.deferred import dataclass
from sim_nodes.faults.actuators import Actuator
from sim_nodes.faults.checks import Check, Checking, SilenceCheck
from sim_nodes.faults.devices import Device, Source
from sim_nodes.faults.validation import cannot_have
from sim_nodes.outcomes import GoalResult, operation_failed, unknown
from sim_nodes.stateful import State, Stateful
from sim_nodes.ticks import TICK

STANDSTILL = 0.5  # [s]


class BlackoutCheck(Check[int]):
    """Checks that no sensor or camera of a robot sends data, and that all actuators are at rest.

    Args:
        sources: Sensors and cameras by name.
        drives: Actuators by name.
    """

    STATE = ("_silences", "_rest")

    def __init__(self, sources: Mapping[str, Source], drives: Mapping[str, Actuator]) -> None:
        self._sources = sources
        self._drives = drives
        self._silences = {name: SilenceCheck() for name in sources}
        self._rest = dict.fromkeys(drives, 0)  # ticks at rest in a row, by actuator

    def observe(self, seen: int) -> None:
        """Update with a tick."""
        for name, silence in self._silences.items():
            silence.observe(self._sources[name].observation(seen))
        self._rest = {
            name: ticks + 1 if self._drives[name].is_at_rest else 0 for name, ticks in self._rest.items()
        }

    @property
    def is_confirmed(self) -> bool:
        """Whether the blackout is confirmed."""
        are_silent = all(check.is_confirmed for check in self._silences.values())
        return are_silent and all(ticks * TICK >= STANDSTILL for ticks in self._rest.values())

    def summary(self) -> str:
        """Return a text for each source and actuator."""
        texts = [f"{name}: {check.summary()}" for name, check in self._silences.items()]
        resting = (
            f"{self._drives[name].info.parts} have been at rest for {ticks * TICK:.2f} s"
            for name, ticks in self._rest.items()
        )
        return "; ".join([*texts, *resting])


class RobotPower(Device):
    """A robot as a device that can lose its power.

    Args:
        sources: Sensors and cameras by name. At least one is needed, to observe the loss of power.
        drives: Actuators by name.
    """

    STATE = ("_faults",)

    def __init__(self, sources: Mapping[str, Source], drives: Mapping[str, Actuator]) -> None:
        self._sources = sources
        self._drives = drives
        self._faults: dict[str, Fault] = {}

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, PowerLoss):
            raise cannot_have("robot", fault, "it can have power_loss only; inject other faults into its devices")

    def add_fault(self, fault: Fault) -> None:
        """See `Device`."""
        self._faults[fault.kind] = fault
        self._supply(False)

    def remove_fault(self, kind: str) -> None:
        """See `Device`."""
        if self._faults.pop(kind, None) is not None:
            self._supply(True)

    def _supply(self, on: bool) -> None:
        parts: tuple[Source | Actuator, ...] = (*self._sources.values(), *self._drives.values())
        for part in parts:
            part.set_power(on)

    def start_check(self, fault: Fault) -> Checking:
        """See `Device`."""
        return BlackoutCheck(self._sources, self._drives), int  # the check observes ticks


LONGEST_LIMIT = 3600.0  # [s]


@dataclass
class _Measurement:
    """A running check of a fault."""

    device: str
    fault: Fault
    deadline: int  # tick
    checking: Checking


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

    @property
    def is_busy(self) -> bool:
        """Whether it has running checks, or results to report in the next tick."""
        return bool(self._measured or self._ended)

    def save(self) -> State:
        """See `Stateful`; saves the running checks, which are not made with the robot."""
        self._abort_deleted()
        devices = {name: device.save() for name, device in self._devices.items()}
        measured = {
            identifier: (each.device, each.fault, each.deadline, each.checking[0].save())
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
            measured.checking[0].restore(check)
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
