"""Parameter files.

A parameter file is YAML: under the name of the scenario, a mapping of its parameters. Physical parameters are
numbers in SI base units.

    example_simulation:
      robot:
        namespace: r1
      speed: 0.3
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from seoro.errors import UsageError
from seoro.files.inputs import Kind, failure_reason, read_input_text


def read_parameters(path: Path, scenario: str) -> dict[str, str]:
    """Read a parameter file into expressions of the language, by paths of parameters.

    Args:
        path: The file.
        scenario: Name of the scenario to run.

    Raises:
        UsageError: The file cannot be read, or is invalid.
    """
    import yaml  # noqa: PLC0415 - slow to load, and seldom needed

    from seoro.files.plain_yaml import load_yaml  # noqa: PLC0415 - the same

    try:
        content = load_yaml(read_input_text(path, Kind.SETTINGS), references=True)
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the parameter file {path}: {failure_reason(error)}") from error
    except yaml.YAMLError as error:
        raise UsageError(f"invalid YAML in the parameter file {path}: {error}") from error
    if not isinstance(content, dict) or not isinstance(content.get(scenario), dict):
        found = ", ".join(map(str, content)) if isinstance(content, dict) else type(content).__name__
        raise UsageError(
            f"the parameter file {path} has no mapping for the scenario `{scenario}`",
            help=f"keys in the file: {found}",
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
        UsageError: The value has no equivalent in the language.
    """
    match value:
        case bool():
            return "true" if value else "false"
        case int():
            return repr(value)
        case float() if math.isfinite(value):
            return repr(value)
        case str():
            from json import dumps  # noqa: PLC0415 - seldom needed

            return dumps(value, ensure_ascii=False)
        case list() | tuple():
            return f"[{', '.join(to_expression(item, where) for item in value)}]"
        case _:
            raise UsageError(
                f"{where}: expected a bool, a finite number, a text or a list of these, found {value!r} "
                f"({type(value).__name__})"
            )
