"""Command lines of the scenarios to compare."""

from __future__ import annotations

import re
import runpy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

PROJECT: Final = Path(__file__).resolve().parents[2]
SEED: Final = "0"

VIRTUAL: Final = ("--clock", "virtual")
# Scenarios that need a simulator by the fixture of their folder, not by a comment.
WORLDS: Final = {"scenarios/cameras/snapshots.osc": ("--sim", "mujoco", "--world", "empty", "--rate", "max")}

ON_ROS: Final = "scenarios/cookbook/wait_for_a_topic.osc"  # needs a ROS 2 system and the real clock

_SIMULATORS: Final = re.compile(r"^# seoro: simulators (.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Run:
    """A command line to compare.

    Args:
        name: Name of the scenario, with the simulator.
        arguments: Command and options; a run is given an output folder, too.
    """

    name: str
    arguments: tuple[str, ...]

    @property
    def has_output(self) -> bool:
        """Whether it writes files, such as a trace."""
        return self.arguments[0] == "exec"


def conformance_runs(folder: Path) -> Iterator[Run]:
    """Yield the cases of a folder; its runner `run.py` parses their expectations and arguments."""
    runner = runpy.run_path(str(folder / "run.py"))
    for path in runner["find_cases"](root=folder):
        case = runner["load_case"](path)
        name = path.relative_to(folder.resolve()).as_posix()
        if case.is_check:
            yield Run(name, ("check", "--format", "json", str(path)))
        else:
            yield Run(name, ("exec", str(path), *VIRTUAL, "--seed", SEED, *case.args))


def project_runs(simulators: Sequence[str]) -> Iterator[Run]:
    """The scenarios of this project.

    Args:
        simulators: Simulators to use, where a scenario can run in them; without any, scenarios that need none.
    """
    for path in sorted([*PROJECT.glob("scenarios/**/*.osc"), *PROJECT.glob("examples/**/*.osc")]):
        name = path.relative_to(PROJECT).as_posix()
        common = ("exec", str(path), "--seed", SEED)
        if name == ON_ROS:
            continue
        if name in WORLDS:
            if WORLDS[name][1] in simulators:
                yield Run(name, (*common, *WORLDS[name]))
            continue
        found = _SIMULATORS.search(path.read_text(encoding="utf-8"))
        if found is None:
            yield Run(name, (*common, *VIRTUAL))
            continue
        for simulator in simulators:
            if simulator in re.split(r"[,\s]+", found[1]):
                yield Run(f"{name} [{simulator}]", (*common, "--sim", simulator, "--rate", "max"))
