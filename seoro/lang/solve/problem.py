"""What is asked, what is answered, and the ways in which there is no answer."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING

from seoro.lang import frozen
from seoro.lang.solve.cells import Cell, Value
from seoro.lang.solve.terms import Term

if TYPE_CHECKING:
    from seoro.lang.source import Span


class Strength(Enum):
    """How a constraint was written (7.3.11.3). Both hold: what was overridden is not part of a problem."""

    HARD = "hard"
    DEFAULT = "default"


class Constraint(frozen.Frozen):
    """Something that has to hold.

    Args:
        term: What, as a term that is true or false.
        span: Where it was written.
        text: What people see of it, such as `keep(x < 3)`.
        strength: How it was written.
        origin: Where it came from if not from the text, such as `--set`; may be empty.
    """

    term: Term
    span: Span
    text: str
    strength: Strength = Strength.HARD
    origin: str = ""


class Problem(frozen.Frozen):
    """Cells to find values for, and what has to hold for them; constraints mention no other cells."""

    cells: tuple[Cell, ...]
    constraints: tuple[Constraint, ...]


class Solution(frozen.Frozen):
    """A value for each cell, in the order of the problem."""

    values: Mapping[Cell, Value]


class Unsolved(Exception):
    """No values were found; the subclasses say why."""


class Conflict(Unsolved):
    """Constraints that cannot all hold.

    Args:
        constraints: Which, in the order of places. Without any one of them the others can hold, unless that could
            not be decided.
        limits: Cells whose own domain is part of the conflict, such as a `uint` that would be negative.
        reason: Why nothing satisfies the only constraint, if its evaluation said so; may be empty.
    """

    def __init__(
        self, constraints: tuple[Constraint, ...], limits: tuple[Cell, ...] = (), reason: str = ""
    ) -> None:
        super().__init__("these cannot all hold: " + ", ".join(constraint.text for constraint in constraints))
        self.constraints = constraints
        self.limits = limits
        self.reason = reason


class Unbounded(Unsolved):
    """A number or a string that nothing bounds.

    Args:
        cell: Which.
    """

    def __init__(self, cell: Cell) -> None:
        super().__init__(f"'{cell.name}' has no value: give it a default, a constraint or an override")
        self.cell = cell


class NeedsSolver(Unsolved):
    """The constraints are too hard for bounded search, and z3 is not installed.

    Args:
        cells: The cells that they are about.
    """

    def __init__(self, cells: tuple[Cell, ...]) -> None:
        super().__init__(
            f"the constraints on {_some(cells)} need a solver that is not installed: install `seoro[solver]`"
        )
        self.cells = cells


class Undecided(Unsolved):
    """Neither values nor a proof that there are none were found within the limits.

    Args:
        cells: The cells that it is about.
    """

    def __init__(self, cells: tuple[Cell, ...]) -> None:
        super().__init__(
            f"no values were found for {_some(cells)} within the limits of effort: "
            "bound them more closely or give some of them a value"
        )
        self.cells = cells


def _some(cells: tuple[Cell, ...], most: int = 3) -> str:
    names = ", ".join(f"'{cell.name}'" for cell in cells[:most])
    return f"{names} and {len(cells) - most} more" if len(cells) > most else names
