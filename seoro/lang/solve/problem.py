"""Problems, solutions, and errors without a solution."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING

from seoro.lang import frozen
from seoro.lang.solve.terms import Cell, Term, Value

if TYPE_CHECKING:
    from seoro.lang.source import Span


class Strength(Enum):
    """Strength of a constraint (7.3.11.3). Both have to hold: a problem excludes overridden constraints."""

    HARD = "hard"
    DEFAULT = "default"


class Constraint(frozen.Frozen):
    """A condition on cells.

    Args:
        term: The condition, as a boolean term.
        span: Its place in the text.
        text: Its text for people, such as `keep(x < 3)`.
        strength: Its strength.
        origin: Origin outside of the text, such as `--set`; may be empty.
    """

    term: Term
    span: Span
    text: str
    strength: Strength = Strength.HARD
    origin: str = ""


class Problem(frozen.Frozen):
    """Cells without values, and the constraints on them; constraints contain no other cells."""

    cells: tuple[Cell, ...]
    constraints: tuple[Constraint, ...]


class Solution(frozen.Frozen):
    """A value for each cell, in the order of the problem."""

    values: Mapping[Cell, Value]


class Unsolved(Exception):
    """Base of errors without a solution."""


class Conflict(Unsolved):
    """Constraints that cannot all hold.

    Args:
        constraints: The constraints, by place. Without any of them the others have a solution, unless that is
            undecided.
        limits: Cells whose domain is part of the conflict, such as a `uint` that would be negative.
        reason: Reason why the only constraint cannot be evaluated; may be empty.
    """

    def __init__(
        self, constraints: tuple[Constraint, ...], limits: tuple[Cell, ...] = (), reason: str = ""
    ) -> None:
        super().__init__(
            "these constraints contradict each other: " + ", ".join(constraint.text for constraint in constraints)
        )
        self.constraints = constraints
        self.limits = limits
        self.reason = reason


class Unbounded(Unsolved):
    """A number without bounds, or a string without an equality.

    Args:
        cell: Its cell.
    """

    def __init__(self, cell: Cell) -> None:
        super().__init__(f"'{cell.name}' has no value: give it a default, a constraint or an override")
        self.cell = cell


class NeedsSolver(Unsolved):
    """A bounded search did not decide, and z3 is not installed.

    Args:
        cells: The cells without values.
    """

    def __init__(self, cells: tuple[Cell, ...]) -> None:
        super().__init__(f"the constraints on {_some(cells)} need a solver: install `seoro[solver]`")
        self.cells = cells


class Undecided(Unsolved):
    """Neither a solution nor a contradiction was found within the limits.

    Args:
        cells: The cells without values.
    """

    def __init__(self, cells: tuple[Cell, ...]) -> None:
        super().__init__(
            f"found no values for {_some(cells)} within the limits of effort: "
            "narrow their bounds, or set some of them"
        )
        self.cells = cells


def _some(cells: tuple[Cell, ...], most: int = 3) -> str:
    names = ", ".join(f"'{cell.name}'" for cell in cells[:most])
    return f"{names} and {len(cells) - most} more" if len(cells) > most else names
