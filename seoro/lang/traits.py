"""Traits of parameters whose Python implementation takes something other than a value of the declared type."""

from __future__ import annotations

from enum import Enum


class ParameterTrait(Enum):
    """Rule for checking and passing an argument."""

    VALUE = "value"  # a value of the declared type
    ANY = "any"  # a value of any type
    VARIABLE = "variable"  # the path of a variable
    NUMBER = "number"  # the path of a variable that holds a number
    FILE = "file"  # a value of the declared type that names a file or folder beside the scenario
    URI = "uri"  # a value of the declared type that names a model or world for a simulator
