"""`seoro config`: show the settings of a run, and where each comes from."""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

from seoro.cli.arguments import add_option
from seoro.cli.tables import table
from seoro.embed.directives import Directives, read_directives
from seoro.embed.scenarios import check_file
from seoro.embed.time_limit import DEFAULT
from seoro.lang.projects import SETTINGS, TEST, TEST_SETTINGS, Project, project_of

EXAMPLES = """examples:
  seoro config
  seoro config deliver.osc
  seoro config --json

The project of a scenario file is the nearest folder upwards with `seoro.toml`, or with `[tool.seoro]` in
`pyproject.toml`. Options of the command line come before variables of the environment, these before directives of
the file (`# seoro: world hall.yaml`), and these before settings of the project."""

_VARIABLES: Final = {"endpoint": "SEORO_EXECUTOR"}
_DEFAULTS: Final = {"rate": 1.0, "timeout": DEFAULT}


class _Row(NamedTuple):
    """A setting with its value, and where it comes from."""

    setting: str
    value: Any
    origin: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", nargs="?", help="scenario file (.osc) with directives")
    add_option(parser, "--scenario NAME", "scenario of the file, if it has several")
    add_option(parser, "--json", "print a JSON object with the file of the project and all settings")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    place = Path.cwd() if options.file is None else Path(options.file).absolute().parent
    project = project_of(place)
    directives = Directives() if options.file is None else _directives(Path(options.file), options.scenario)
    rows = [_row(key, project, directives) for key in SETTINGS]
    rows += _test_rows(project)
    if options.json:
        found = {row.setting: {"value": _plain(row.value), "from": row.origin} for row in rows}
        print(json.dumps({"project": project and str(project.file), "settings": found}, indent=1))
        return
    print(f"project: {project.file if project is not None else 'none'}\n")
    print(table([("SETTING", "VALUE", "FROM"), *((row.setting, _shown(row.value), row.origin) for row in rows)]))


def _directives(file: Path, name: str | None) -> Directives:
    """Return the directives of a scenario of a file.

    Raises:
        InvalidScenario, UsageError: The file has errors, or has no such scenario.
    """
    scenario = check_file(file, import_python=False).without_errors()
    found = read_directives(scenario.file, scenario.scenario_lines)
    return found.scenarios.get(scenario.entry(name).line, found.common)


def _row(key: str, project: Project | None, directives: Directives) -> _Row:
    variable = _VARIABLES.get(key, "")
    if variable and os.environ.get(variable):
        return _Row(key, os.environ[variable], variable)
    of_file = {
        "simulator": next(iter(directives.simulators), None),
        "world": directives.world,
        "timeout": directives.timeout,
    }.get(key)
    if of_file is not None:
        return _Row(key, of_file, "the scenario file")
    if project is not None and key in project.values:
        value = project.values[key]
        return _Row(key, f"({len(value)} not shown)" if SETTINGS[key].is_secret else value, project.file.name)
    return _Row(key, _DEFAULTS.get(key), "default")


def _test_rows(project: Project | None) -> Iterator[_Row]:
    for key in TEST_SETTINGS:
        is_set = project is not None and key in project.test
        yield _Row(
            f"{TEST}.{key}",
            project.test[key] if project is not None and is_set else None,
            project.file.name if project is not None and is_set else "default",
        )


def _plain(value: Any) -> Any:
    match value:
        case tuple():
            return [_plain(each) for each in value]
        case frozenset():
            return sorted(value)
        case Path():
            return str(value)
        case math.inf:
            return "max"
    return value


def _shown(value: Any) -> str:
    plain = _plain(value)
    match plain:
        case None:
            return "-"
        case list():
            return ", ".join(plain)
        case float():
            return f"{plain:g}"
    return str(plain)
