"""What the Python implementation of an action takes for a parameter, where it is not just a value of its type."""

from __future__ import annotations

from enum import Enum


class ParameterTrait(Enum):
    """How an argument is checked and passed."""

    VALUE = "value"  # a value of the declared type
    ANY = "any"  # a value of any type
    REFERENCE = "reference"  # the path of a variable
