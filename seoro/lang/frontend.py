"""The front end in three steps: `load` reads, `check` finds what is wrong, `lower` makes the plan."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from seoro.lang import loader
from seoro.lang.check.arguments import NO_TRAITS, Traits
from seoro.lang.check.checker import Checked, run_checks
from seoro.lang.check.recall import BodyMessages
from seoro.lang.loader import PARSERS, Parsers, Reader, Sources, read_file
from seoro.lang.lower.lower import lower_scenario
from seoro.lang.plan import Plan
from seoro.lang.recorder import Recorder
from seoro.lang.traits import ParameterTrait
from seoro.located import Locate, as_named

__all__ = ["Checked", "ParameterTrait", "Sources", "check", "load", "lower"]

_NO_OVERRIDES: Mapping[str, str] = {}


def load(
    path: Path,
    name: str | None = None,
    read: Reader = read_file,
    locate: Locate = as_named,
    parsers: Parsers = PARSERS,
) -> Sources:
    """Read and parse a scenario file and all it imports.

    Faults in the texts do not raise: they stand in the `diagnostics` of what is returned.

    Args:
        path: The file.
        name: How to call it in messages; as it was given unless said otherwise.
        read: Gives the texts of files.
        locate: Gives the places of those that are imported by absolute paths.
        parsers: Parse the files.
    """
    return loader.load(path, name, read, locate, parsers)


def check(
    sources: Sources,
    traits: Traits = NO_TRAITS,
    strict: bool = False,
    recorder: Recorder | None = None,
    known: BodyMessages | None = None,
) -> Checked:
    """Check a loaded scenario; what is wrong stands in the `diagnostics` of what is returned.

    Args:
        sources: What `load` gave.
        traits: What the Python implementations of actions and modifiers take, where it is not a value of the
            declared type.
        strict: Whether to warn of extensions to the standard.
        recorder: Is told what names mean and of what types values are.
        known: What is known from an earlier check of the same file.
    """
    return run_checks(sources, traits, strict, recorder, known)


def lower(checked: Checked, scenario: str | None = None, overrides: Mapping[str, str] = _NO_OVERRIDES) -> Plan:
    """The plan of a scenario.

    Args:
        checked: What `check` gave.
        scenario: The scenario to run; by default the only one of the file, or the one named `main`.
        overrides: Values for parameters of the scenario, or for fields of them (`robot.namespace`), as
            expressions of the language.

    Raises:
        InvalidScenario: There are errors, no scenario to run, or a parameter without a value.
    """
    return lower_scenario(checked, scenario, overrides)
