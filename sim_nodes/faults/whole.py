"""A robot as a whole, which can lose its power."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges.wire import Fault, PowerLoss
from sim_nodes.faults.arrivals import SilenceCheck
from sim_nodes.faults.check import Check
from sim_nodes.faults.devices import Device, Motors, ReadMotion, Source, cannot_have
from sim_nodes.faults.motors import RestCheck


class Blackout(Check):
    """Whether no sensor or camera of a robot sends anything, and its wheels are at rest.

    Args:
        sources: Names of the sensors and cameras.
        wheels: How many sets of wheels it has.
    """

    STATE = ("sources", "wheels")

    def __init__(self, sources: Sequence[str], wheels: int) -> None:
        self.sources = {name: SilenceCheck() for name in sources}
        self.wheels = [RestCheck() for _ in range(wheels)]

    @property
    def holds(self) -> bool:
        """Whether that is so."""
        return all(check.holds for check in (*self.sources.values(), *self.wheels))

    def figures(self) -> str:
        """Of each source and the wheels."""
        told = [f"{name}: {check.figures()}" for name, check in self.sources.items()]
        return "; ".join([*told, *(check.figures() for check in self.wheels)])


class WholeRobot(Device):
    """A robot as a whole: it can lose its power.

    Args:
        sources: Its sensors and cameras, by their names.
        motors: Its motors, if it has some.
        motion: Reads what its wheels do.
    """

    STATE = ("_faults",)

    def __init__(self, sources: Mapping[str, Source], motors: Motors | None, motion: ReadMotion) -> None:
        self._sources = sources
        self._motors = motors
        self._motion = motion
        self._faults: dict[str, Fault] = {}

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, PowerLoss):
            raise cannot_have("robot", fault, "it can have power_loss; others are those of its devices")

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        self._faults[fault.kind] = fault
        self._supply(False)

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if self._faults.pop(kind, None) is not None:
            self._supply(True)

    def _supply(self, on: bool) -> None:
        for source in self._sources.values():
            source.supply(on)
        if self._motors is not None:
            self._motors.supply(on)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        return Blackout(tuple(self._sources), 0 if self._motors is None else 1)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, Blackout)
        for name, silence in check.sources.items():
            silence.observe(self._sources[name].observation(tick))
        for rest in check.wheels:
            rest.observe(self._motion())
