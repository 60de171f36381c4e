"""The command line, from its parsers."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from unittest.mock import patch

from seoro.cli.commands import COMMANDS
from seoro.cli.main import command_parser
from tests.tools.reference.tables import cell, code, table


def commands() -> str:
    """Return a section for each command: description, usage, options and examples."""
    with patch.dict(os.environ, {"COLUMNS": "102"}):
        return "\n".join(_section(name, parser, 2) for name, parser in _parsers())


def _parsers() -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for name in COMMANDS:
        parser = command_parser([name])
        yield name, _below(parser)[name]


def _below(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    found: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found |= action.choices
    return found


def _section(name: str, parser: argparse.ArgumentParser, level: int) -> str:
    usage = parser.format_usage().removeprefix("usage: ").rstrip().replace("\n" + " " * len("usage: "), "\n")
    parts = [f"{'#' * level} seoro {name}\n", f"{parser.description or ''}\n", f"```text\n{usage}\n```\n"]
    rows = [(_names(action), _help(parser, action)) for action in parser._actions if _is_listed(action)]
    if rows:
        parts.append(table(("argument", "meaning"), rows))
    if parser.epilog:
        parts.append(f"```text\n{parser.epilog.strip()}\n```\n")
    parts += [_section(f"{name} {below}", each, level + 1) for below, each in _below(parser).items()]
    return "\n".join(parts)


def _is_listed(action: argparse.Action) -> bool:
    hidden = action.help == argparse.SUPPRESS or "--help" in action.option_strings
    return not hidden and not isinstance(action, argparse._SubParsersAction)


def _names(action: argparse.Action) -> str:
    value = action.metavar or (action.dest.upper() if action.option_strings else action.dest)
    shown = " ".join(value) if isinstance(value, tuple) else value
    if not action.option_strings:
        return code(shown)
    names = ", ".join(map(code, action.option_strings))
    return names if action.nargs == 0 else f"{names} {code(shown)}"


def _help(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    return cell(parser._get_formatter()._expand_help(action)) if action.help else ""
