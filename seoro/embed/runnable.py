"""Protocol of scenario files that can be run: checked now, or read from the cache."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from seoro.bindings.bound_functions import BoundFunctions
from seoro.lang.frozen import Value
from seoro.lang.plan import Plan
from seoro.lang.source import SourceFile


class Entry(Value):
    """Scenario of a file that runs.

    Args:
        name: Qualified name.
        line: Line of the file that names it, from 1.
    """

    name: str
    line: int


class Runnable(Protocol):
    """Scenario file without errors, with its Python functions."""

    @property
    def functions(self) -> BoundFunctions:
        """Functions that implement actions and modifiers."""

    @property
    def file(self) -> SourceFile:
        """The file."""

    @property
    def files(self) -> tuple[SourceFile, ...]:
        """The file and all its imports."""

    @property
    def scenario_lines(self) -> frozenset[int]:
        """The lines of the file that name its own scenarios, from 1."""

    def entry(self, name: str | None) -> Entry:
        """Find the scenario to run.

        Raises:
            InvalidScenario: The name is unknown or ambiguous.
        """

    def plan(self, name: str | None, overrides: Mapping[str, str], constraints: Sequence[str] = ()) -> Plan:
        """Make the plan of a scenario.

        Args:
            name: Name of the scenario; None for the entry of the file.
            overrides: Expressions for parameters, by their paths.
            constraints: Further constraints on parameters, as boolean expressions.

        Raises:
            InvalidScenario: The scenario is unknown, or a parameter has no value.
        """
