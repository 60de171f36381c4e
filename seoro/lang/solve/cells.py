"""Cells, the unknowns of a problem, and the domains that their types give them."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang import frozen
from seoro.lang.integers import INT_LIMITS

if TYPE_CHECKING:
    from seoro.lang.source import Span

# A bool, an int, a float, a string, or a token: any other object, of which only equality matters, such as a
# member of an enumeration or a reference to an actor.
Value: TypeAlias = Hashable


class Boolean(frozen.Value):
    """True or false."""


class Choice(frozen.Value):
    """One of a few values, such as the members of an enumeration; at least one, no two equal."""

    values: tuple[Value, ...]


class Integer(frozen.Value):
    """A whole number, bounds included. The full limits of a type count as no bounds at all."""

    low: int = INT_LIMITS[0]
    high: int = INT_LIMITS[1]


class Real(frozen.Value):
    """A float, or a physical value in the SI unit of its dimension; bounds included."""

    low: float = float("-inf")
    high: float = float("inf")


class Free(frozen.Value):
    """Anything that only equality can fix: a string, a reference."""


Domain: TypeAlias = Boolean | Choice | Integer | Real | Free


class Cell(frozen.Frozen):
    """One unknown; a cell equals only itself.

    Args:
        name: Its path, as people see it: `robot.goal.x`. Unique in a problem: its random stream is named by it.
        span: Where it is declared.
        domain: What its type allows.
    """

    name: str
    span: Span
    domain: Domain
