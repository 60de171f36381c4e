"""Loss of power of a whole robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seoro.bridges.wire import Fault, PowerLoss
from sim_nodes.faults.actuators import Actuator
from sim_nodes.faults.check import Check, Checking, Observation
from sim_nodes.faults.delivery_checks import SilenceCheck
from sim_nodes.faults.devices import Device, Source, cannot_have
from sim_nodes.ticks import TICK

STANDSTILL = 0.5  # [s]


class RestCheck(Check[bool]):
    """Checks that something is at rest despite its commands.

    Args:
        parts: Text for the moving parts.
    """

    STATE = ("_ticks",)

    def __init__(self, parts: str) -> None:
        self._parts = parts
        self._ticks = 0  # in a row

    def observe(self, seen: bool) -> None:
        """Update with whether it is at rest in a tick."""
        self._ticks = self._ticks + 1 if seen else 0

    @property
    def is_confirmed(self) -> bool:
        """Whether the rest is confirmed."""
        return self._ticks * TICK >= STANDSTILL

    def summary(self) -> str:
        """Return a text with the duration."""
        return f"{self._parts} have been at rest for {self._ticks * TICK:.2f} s"


@dataclass(frozen=True)
class PowerObservation:
    """Data of the sensors and cameras of a robot in a tick, and whether its actuators are at rest, by name."""

    sources: Mapping[str, Observation[Any]]
    at_rest: Mapping[str, bool]


class BlackoutCheck(Check[PowerObservation]):
    """Checks that no sensor or camera of a robot sends data, and that all actuators are at rest.

    Args:
        sources: Names of the sensors and cameras.
        parts: Texts for the moving parts, by actuator.
    """

    STATE = ("_sources", "_drives")

    def __init__(self, sources: Sequence[str], parts: Mapping[str, str]) -> None:
        self._sources = {name: SilenceCheck() for name in sources}
        self._drives = {name: RestCheck(moved) for name, moved in parts.items()}

    def observe(self, seen: PowerObservation) -> None:
        """Update with a tick."""
        for name, silence in self._sources.items():
            silence.observe(seen.sources[name])
        for name, rest in self._drives.items():
            rest.observe(seen.at_rest[name])

    @property
    def is_confirmed(self) -> bool:
        """Whether the blackout is confirmed."""
        checks: tuple[Check[Any], ...] = (*self._sources.values(), *self._drives.values())
        return all(check.is_confirmed for check in checks)

    def summary(self) -> str:
        """Return a text for each source and actuator."""
        texts = [f"{name}: {check.summary()}" for name, check in self._sources.items()]
        return "; ".join([*texts, *(check.summary() for check in self._drives.values())])


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
        parts = {name: drive.parts for name, drive in self._drives.items()}
        return BlackoutCheck(tuple(self._sources), parts), self._observation

    def _observation(self, tick: int) -> PowerObservation:
        return PowerObservation(
            {name: source.observation(tick) for name, source in self._sources.items()},
            {name: drive.is_at_rest for name, drive in self._drives.items()},
        )
