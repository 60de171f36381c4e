"""`Settings`: the settings of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.files.path_mapping import Locate, unchanged_path
from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile
from seoro.runtime.contracts.backends import Backend
from seoro.runtime.events.occurrence import Occurrence
from seoro.runtime.execution.assignment import Placement
from seoro.runtime.execution.services import Debugging
from seoro.runtime.functions.actions import BoundAction
from seoro.runtime.kernel.clock import Clock
from seoro.runtime.kernel.delta import StepOrder

if TYPE_CHECKING:
    from seoro.runtime.contracts.observers import Observer
    from seoro.runtime.functions.modifiers import BoundModifier


class Settings(Value):
    """Settings of a run.

    Args:
        seed: Seed of all random numbers.
        clock: The run's clock.
        rate: Rate of a simulated clock, recorded in the trace; infinite for as fast as possible.
        backends: Backends of actors; the caller opens them, and closes them after the run.
        placements: Homes of actors chosen by the user, by actor name.
        observers: Observers of the trace.
        actions: Actions implemented in Python, by qualified name.
        modifiers: Modifiers implemented in Python, by qualified name.
        output_directory: Output folder of the run, available to library methods.
        locate: Maps absolute paths of files.
        overrides: Parameters set by the user, by path, as expressions of the language; recorded in the trace.
        constraints: Constraints on parameters set by the user; recorded in the trace.
        requirements: Names of requirements that the scenario covers; recorded in the trace.
        grace: Time for the clean-up of a cancelled action [s], on the machine's clock.
        version: Version of seoro, recorded in the trace.
        sources: Texts of the scenario, recorded in the trace.
        external: Names of the events that the application may emit.
        recorded: Emissions of an earlier run, to be repeated at their times; None to wait for the application.
        pose_rate: Samples of poses in the trace [1/s]; 0 for none.
        scan_rate: Scans of each lidar in the trace [1/s]; 0 for none.
        debugger: Control of the run, on a deterministic clock.
        step_order: Order of steps in a delta cycle, as for `Scheduler`; tests check that it has no effect.
    """

    seed: int
    clock: Clock
    rate: float = math.inf
    backends: Sequence[Backend] = ()
    placements: Mapping[str, Placement] = field(default_factory=dict)
    observers: Sequence[Observer] = ()
    actions: Mapping[str, BoundAction] = field(default_factory=dict)
    modifiers: Mapping[str, BoundModifier] = field(default_factory=dict)
    output_directory: Path | None = None
    locate: Locate = unchanged_path
    overrides: Mapping[str, str] = field(default_factory=dict)
    constraints: Sequence[str] = ()
    requirements: Sequence[str] = ()
    grace: float = 5.0
    version: str = ""
    sources: Sequence[SourceFile] = ()
    external: Sequence[str] = ()
    recorded: Sequence[Occurrence] | None = None
    pose_rate: float = 0.0
    scan_rate: float = 0.0
    debugger: Debugging | None = None
    step_order: StepOrder | None = None

    @property
    def named_robots(self) -> dict[str, str]:
        """Robots chosen by the user, by actor, as traces have them."""
        homes = {name: each.home for name, each in self.placements.items()}
        return {name: f"{home.name} of {home.backend.name}" for name, home in sorted(homes.items())}
