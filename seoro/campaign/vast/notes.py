"""Parts of a RoboVAST file that a campaign cannot have, each with the reason and what to do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from seoro.files.yaml_lines import Lines
from seoro.lang.frozen import Value

PARTS: Final[Mapping[tuple[str, ...], tuple[str, str]]] = {
    ("metadata",): ("campaigns have no metadata", "write it as a comment of the campaign file"),
    ("general",): ("its options are those of plugins", "write values into the scenario"),
    ("execution", "image"): (
        "runs are processes of this machine, not containers",
        "install what the scenario starts here, or run an executor in the container (`seoro serve`)",
    ),
    ("execution", "resources"): ("processes have no limits of their own", "limit simultaneous runs by `jobs`"),
    ("execution", "secondary_containers"): (
        "containers are not started",
        "start them before the campaign, or from the scenario with `run_process`",
    ),
    ("execution", "env"): ("runs have the environment of the command", "set the variables before the command"),
    ("execution", "pre_command"): ("no program runs before a run", "start it in the scenario, `run_process(...)`"),
    ("execution", "post_command"): ("no program runs after a run", "start it in the scenario, `run_process(...)`"),
    ("execution", "simulation"): ("the class of a simulator is unknown here", "add `simulator: mujoco`"),
    ("search", "postprocessing"): (
        "results are not processed by Python",
        "record values in the scenario, `record(...)`, or read `runs.csv` and `kept/`",
    ),
    ("results_processing",): (
        "results are not processed by Python",
        "record values in the scenario, `record(...)`, or read `runs.csv` and `kept/`",
    ),
    ("evaluation",): ("notebooks are not run", "see `report.html`, or read `runs.csv` in the notebook"),
}
"""Reason and advice by place in the file."""


class Note(Value):
    """Part that is not carried over.

    Args:
        place: Place in the file, as keys and indices.
        what: The part.
        why: Reason.
        advice: Alternative for the user.
    """

    place: Sequence[str | int]
    what: str
    why: str
    advice: str

    def text(self, lines: Lines) -> str:
        """Describe it in one line, with its place."""
        return f"{lines.at(self.place)}: {self.what}: {self.why}; {self.advice}"
