"""Contract of backends that inject faults into sensors, cameras and motors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from seoro.robotics.faults import Fault
from seoro.runtime.contracts.backends import Reporter


@runtime_checkable
class Faults(Protocol):
    """Faults of sensors, cameras and motors.

    `robot` is the name from `assign_robot`, `device` a device of that robot. Free cameras belong to no robot:
    pass an empty robot name.
    """

    def devices(self) -> Mapping[str, Sequence[str]]:
        """Return the device names of each robot, in their order."""
        ...

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """Inject a fault, replacing another of its kind, and measure its effect.

        The measurement is reported as success, or as abortion if no effect was measured within `limit` [s]; the
        fault is then cleared. Return the id of the measurement.
        """
        ...

    async def cancel_fault(self, measurement: str) -> None:
        """Clear a fault whose effect is being measured. Finished measurements are ignored."""
        ...

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """Clear the faults of a device (all devices if empty), of one kind if `fault` is given."""
        ...
