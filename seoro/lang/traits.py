"""Traits of parameters whose Python implementation takes something other than a value of the declared type."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple, TypeAlias

Vet: TypeAlias = Callable[[str], tuple[str, str] | None]
"""Returns the problem of a literal text and a hint; None for a suitable one."""


class ParameterTrait(Enum):
    """Rule for checking and passing an argument."""

    VALUE = "value"  # a value of the declared type
    ANY = "any"  # a value of any type
    VARIABLE = "variable"  # the path of a variable
    NUMBER = "number"  # the path of a variable that holds a number
    FILE = "file"  # a value of the declared type that names a file or folder beside the scenario
    URI = "uri"  # a value of the declared type that names a model or world for a simulator


class Vetted(NamedTuple):
    """A text of the declared type whose literals are checked by a function."""

    vet: Vet


Trait: TypeAlias = ParameterTrait | Vetted
