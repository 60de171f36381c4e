"""Values of parameters from a file.

A parameter file is YAML: under the name of the scenario, a mapping of its parameters. Numbers of physical
parameters are in SI base units.

    example_simulation:
      robot:
        namespace: r1
      speed: 0.3
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from seoro.errors import InvalidUse
from seoro.input_files import Kind, read_input_text


def read_parameters(path: Path, scenario: str) -> dict[str, str]:
    """The values in a parameter file, as expressions of the language by the path of the parameter.

    Args:
        path: The file.
        scenario: Name of the scenario that is going to run.

    Raises:
        InvalidUse: The file cannot be read, or is not of the form above.
    """
    import yaml  # noqa: PLC0415 - slow to load, and seldom needed

    from seoro.plain_yaml import load_yaml  # noqa: PLC0415 - the same

    try:
        content = load_yaml(read_input_text(path, Kind.SETTINGS), references=True)
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidUse(f"cannot read the parameter file {path}: {error}") from error
    except yaml.YAMLError as error:
        raise InvalidUse(f"the parameter file {path} is no YAML: {error}") from error
    if not isinstance(content, dict) or not isinstance(content.get(scenario), dict):
        found = ", ".join(map(str, content)) if isinstance(content, dict) else type(content).__name__
        raise InvalidUse(
            f"the parameter file {path} has no mapping under the name of the scenario, `{scenario}`",
            help=f"it has: {found}",
        )
    return dict(_expressions(content[scenario], "", path))


def _expressions(values: dict[Any, Any], prefix: str, path: Path) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        where = f"{prefix}{name}"
        if isinstance(value, dict):
            yield from _expressions(value, f"{where}.", path)
        else:
            yield where, to_expression(value, f"the parameter file {path}: `{where}`")


def to_expression(value: object, where: str) -> str:
    """Convert a plain value into an expression of the language; text becomes a string literal.

    Args:
        value: A bool, a finite number, a text, or a list of such values.
        where: The place of the value, for messages.

    Raises:
        InvalidUse: The language has no such value.
    """
    match value:
        case bool():
            return "true" if value else "false"
        case int():
            return repr(value)
        case float() if math.isfinite(value):
            return repr(value)
        case str():
            return json.dumps(value, ensure_ascii=False)
        case list() | tuple():
            return f"[{', '.join(to_expression(item, where) for item in value)}]"
        case _:
            raise InvalidUse(
                f"{where}: expected a bool, a finite number, a text or a list of these, found {value!r} "
                f"({type(value).__name__})"
            )
