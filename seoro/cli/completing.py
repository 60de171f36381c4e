"""Completion of a command line, for the script of `seoro completion`.

The shell runs `seoro` with the line in its environment, as argcomplete defines. Completions are options,
names of files, scenarios and parameters of a file, worlds, and executors of this machine.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import argcomplete
from argcomplete.completers import FilesCompleter
from argcomplete.lexers import split_line

from seoro.cli.arguments import Parser, actions_of
from seoro.cli.commands import COMMANDS
from seoro.cli.files import SUFFIX, state_folder
from seoro.cli.main import command_parser
from seoro.files.schemas import SCHEMAS

LINE: Final = "COMP_LINE"  # variables of the shell
POINT: Final = "COMP_POINT"

_ENGINES: Final = ("mujoco", "pybullet")

Completer = Callable[..., Iterable[str]]


def complete() -> None:
    """Print the completions of the line in the environment, and end the process."""
    line = os.environ[LINE]
    words = split_line(line, int(os.environ.get(POINT, len(line))))[3]
    chosen = next((word for word in words[1:] if not word.startswith("-")), None)
    parser = _all_commands() if chosen not in COMMANDS else command_parser([str(chosen)])
    for action in actions_of(parser):
        if (completer := _completer(action)) is not None:
            action.completer = completer  # type: ignore[attr-defined]
    argcomplete.autocomplete(parser, always_complete_options="long")


def _all_commands() -> argparse.ArgumentParser:
    parser = Parser(prog="seoro")
    commands = parser.add_subparsers()
    for name, what in COMMANDS.items():
        commands.add_parser(name, help=what)
    return parser


def _completer(action: argparse.Action) -> Completer | None:
    """Return the completer of an argument by its placeholder; None for that of argcomplete, files or choices."""
    if action.choices is not None:
        return None
    if action.metavar == "FILE" and action.help and SUFFIX in action.help:
        return FilesCompleter((SUFFIX[1:],))
    return _COMPLETERS.get(action.option_strings[-1] if action.option_strings else str(action.metavar))


def _worlds(prefix: str, **_: Any) -> Iterable[str]:
    nodes = find_spec("sim_nodes")  # simulators are other processes; their files are at hand
    folders = [] if nodes is None else nodes.submodule_search_locations or []
    bundled = [path.stem for folder in folders for path in Path(folder, "worlds").glob("*.yaml")]
    return [*bundled, *FilesCompleter(("yaml", "sdf"))(prefix)]


def _executors(**_: Any) -> Iterable[str]:
    with suppress(OSError):
        return [each.name for each in state_folder().iterdir() if (each / "runs").is_dir()]
    return []


def _runs(**_: Any) -> Iterable[str]:
    with suppress(OSError):
        return [each.name for name in _executors() for each in (state_folder() / name / "runs").iterdir()]
    return []


def _codes(**_: Any) -> Iterable[str]:
    from seoro.lang.explain import explanations  # noqa: PLC0415 - reads all of them

    return {each.code: each.title for each in explanations()}


def _symbols(prefix: str, **_: Any) -> Iterable[str]:
    from seoro.cli.documentation.reading import known_libraries, read_libraries  # noqa: PLC0415 - parser and checks
    from seoro.cli.documentation.searching import known_names  # noqa: PLC0415 - the same

    files = known_libraries(Path.cwd())
    names = known_names(read_libraries(files, Path.cwd())) if prefix else []
    short = {each.rpartition(".")[2] for each in names}
    return [*files, *names, *short, *FilesCompleter((SUFFIX[1:],))(prefix)]


def _scenarios(parsed_args: argparse.Namespace, **_: Any) -> Iterable[str]:
    return [symbol.name for symbol in _declared(parsed_args)]


def _parameters(parsed_args: argparse.Namespace, **_: Any) -> Iterable[str]:
    """Return the parameters of the scenarios of the file, followed by `=`."""
    chosen = getattr(parsed_args, "scenario", None)
    symbols = [symbol for symbol in _declared(parsed_args) if chosen in (None, symbol.name)]
    fields = [field for symbol in symbols for field in symbol.inventory.fields.values()]
    return [f"{field.name}=" for field in fields if not field.is_variable]


def _declared(options: argparse.Namespace) -> list[Any]:
    from seoro.embed.directives import top_scenarios  # noqa: PLC0415 - parser and checks
    from seoro.embed.scenarios import check_file  # noqa: PLC0415 - the same

    file = getattr(options, "file", None)
    return top_scenarios(check_file(file, import_python=False).checked) if file else []


_COMPLETERS: Final[dict[str, Completer]] = {
    "--on": _executors,
    "--scenario": _scenarios,
    "--set": _parameters,
    "--sim": lambda **_: (*_ENGINES, "ros"),
    "--world": _worlds,
    "CODE": _codes,
    "RUN": _runs,
    "SCHEMA": lambda **_: SCHEMAS,
    "SIMULATOR": lambda **_: _ENGINES,
    "SYMBOL": _symbols,
}
