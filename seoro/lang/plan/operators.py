"""Kinds of operators in expressions of the plan."""

from __future__ import annotations

from enum import Enum


class Number(Enum):
    """Arithmetic of an operator (7.4.2.3.1); physical values are floats."""

    INT = "int"
    UINT = "uint"
    FLOAT = "float"


class Bulk(Enum):
    """Operators that evaluate an expression for each member of a list (7.4.2.7.3)."""

    FILTER = "filter"
    FIRST_INDEX = "first_index"
    COUNT = "count"
    HAS = "has"
    MAP = "map"


class Side(Enum):
    """The bounds of a range."""

    LOWER = "lower"
    UPPER = "upper"


class StringMethod(Enum):
    """The methods of strings (8.13)."""

    LENGTH = "length"
    CONTAINS = "contains"
    SUBSTRING = "substring"
    SPLIT = "split"
    JOIN = "join"
    REPLACE = "replace"
    TRIM = "trim"
