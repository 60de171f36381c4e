"""Front end in three steps: `load` reads and parses, `check` finds errors, `lower` creates the plan."""

from __future__ import annotations

from seoro.lang.check.checker import Checked, check
from seoro.lang.loader import Sources, load
from seoro.lang.lower.lower import lower
from seoro.lang.traits import ParameterTrait

__all__ = ["Checked", "ParameterTrait", "Sources", "check", "load", "lower"]
