"""Cells, the unknowns of a problem, and the domains that their types give them."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang import frozen
from seoro.lang.integers import INT_LIMITS

if TYPE_CHECKING:
    from seoro.lang.source import Span

# A bool, an int, a float, a string, or a token. Tokens are other objects that can only be compared for equality,
# such as members of enumerations or references to actors.
Value: TypeAlias = Hashable


class Boolean(frozen.Value):
    """True or false."""


class Choice(frozen.Value):
    """One of a few different values, such as the members of an enumeration; at least one."""

    values: tuple[Value, ...]


class Integer(frozen.Value):
    """An integer, bounds included. The limits of its type do not count as bounds."""

    low: int = INT_LIMITS[0]
    high: int = INT_LIMITS[1]


class Real(frozen.Value):
    """A float, or a physical value in the SI unit of its dimension; bounds included."""

    low: float = float("-inf")
    high: float = float("inf")


class Free(frozen.Value):
    """A value that only an equality can determine: a string, a reference."""


Domain: TypeAlias = Boolean | Choice | Integer | Real | Free


class Cell(frozen.Frozen):
    """One unknown; a cell equals only itself.

    Args:
        name: Its path for people, such as `robot.goal.x`; unique in a problem, and the name of its random stream.
        span: Its declaration.
        domain: Values of its type.
    """

    name: str
    span: Span
    domain: Domain
