"""A robot as a whole, which can lose its power."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges.wire import Fault, PowerLoss
from sim_nodes.faults.arrivals import SilenceCheck
from sim_nodes.faults.check import Check
from sim_nodes.faults.devices import Device, Source, cannot_have
from sim_nodes.faults.drives import Drive
from sim_nodes.ticks import TICK

STANDSTILL = 0.5  # [s]


class RestCheck(Check):
    """Whether something is at rest, whatever it is commanded.

    Args:
        parts: What moves, in words.
    """

    STATE = ("_ticks",)

    def __init__(self, parts: str) -> None:
        self._parts = parts
        self._ticks = 0  # in a row

    def observe(self, is_at_rest: bool) -> None:
        """Take in a tick."""
        self._ticks = self._ticks + 1 if is_at_rest else 0

    @property
    def holds(self) -> bool:
        """Whether it is."""
        return self._ticks * TICK >= STANDSTILL

    def figures(self) -> str:
        """For how long."""
        return f"{self._parts} have been at rest for {self._ticks * TICK:.2f} s"


class Blackout(Check):
    """Whether no sensor or camera of a robot sends anything, and all that moves is at rest.

    Args:
        sources: Names of the sensors and cameras.
        parts: What moves, in words, by the names of what moves it.
    """

    STATE = ("sources", "drives")

    def __init__(self, sources: Sequence[str], parts: Mapping[str, str]) -> None:
        self.sources = {name: SilenceCheck() for name in sources}
        self.drives = {name: RestCheck(moved) for name, moved in parts.items()}

    @property
    def holds(self) -> bool:
        """Whether that is so."""
        return all(check.holds for check in (*self.sources.values(), *self.drives.values()))

    def figures(self) -> str:
        """Of each source, and of what moves."""
        told = [f"{name}: {check.figures()}" for name, check in self.sources.items()]
        return "; ".join([*told, *(check.figures() for check in self.drives.values())])


class WholeRobot(Device):
    """A robot as a whole: it can lose its power.

    Args:
        sources: Its sensors and cameras, by their names; without any, nothing would show that it has no power.
        drives: What moves it, by names.
    """

    STATE = ("_faults",)

    def __init__(self, sources: Mapping[str, Source], drives: Mapping[str, Drive]) -> None:
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
        parts: tuple[Source | Drive, ...] = (*self._sources.values(), *self._drives.values())
        for part in parts:
            part.supply(on)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        return Blackout(tuple(self._sources), {name: drive.parts for name, drive in self._drives.items()})

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, Blackout)
        for name, silence in check.sources.items():
            silence.observe(self._sources[name].observation(tick))
        for name, rest in check.drives.items():
            rest.observe(self._drives[name].is_at_rest)
