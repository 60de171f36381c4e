"""`seoro doc`: show the documentation of libraries and of their actions, modifiers and types."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.cli.arguments import add_option
from seoro.cli.files import SUFFIX
from seoro.cli.terminal import terminal_columns, use_colour
from seoro.errors import UsageError
from seoro.lang.diagnostics import near

if TYPE_CHECKING:
    from seoro.cli.documentation.items import Library
    from seoro.cli.documentation.text import Page

EXAMPLES = """examples:
  seoro doc                          (lists all libraries)
  seoro doc osc.nav2
  seoro doc nav_to_pose
  seoro doc differential_drive_robot
  seoro doc libraries/beacon.osc
  seoro doc --json osc.nav2

Libraries are those of seoro, of this folder and its project, and of installed packages."""
_MANY: Final = 5  # declarations of one name, beyond which they are listed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "name",
        metavar="SYMBOL",
        nargs="?",
        help=f"library, file ({SUFFIX}), action, modifier, type or unit (default: list the libraries)",
    )
    add_option(parser, "--json", "print JSON")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    from seoro.cli.documentation.reading import (  # noqa: PLC0415 - parser and checks
        heading,
        known_libraries,
        read_libraries,
        read_source,
    )

    folder, name = Path.cwd(), options.name
    files = known_libraries(folder)
    if name is None:
        _list([(each, heading(path)) for each, path in files.items()], as_json=options.json)
    elif library := next((each for each in (name, f"osc.{name}") if each in files), None):
        _show_libraries(read_libraries({library: files[library]}, folder), as_json=options.json)
    elif name.endswith(SUFFIX):
        _show_libraries((read_source(Path(name)),), as_json=options.json)
    else:
        _show_items(read_libraries(files, folder), name, as_json=options.json)


def _list(found: Sequence[tuple[str, str]], *, as_json: bool) -> None:
    if as_json:
        _print_json([{"name": name, "meaning": meaning} for name, meaning in found])
    else:
        print(_page().libraries(found))


def _show_libraries(found: tuple[Library, ...], *, as_json: bool) -> None:
    from seoro.cli.documentation.items import plain  # noqa: PLC0415 - parser and checks

    for library in found:
        if as_json:
            _print_json(plain(library))
        else:
            print(_page().library(library))


def _show_items(libraries: tuple[Library, ...], name: str, *, as_json: bool) -> None:
    """Print the declarations with a name.

    Raises:
        UsageError: The name is unknown.
    """
    from seoro.cli.documentation.items import plain  # noqa: PLC0415 - parser and checks
    from seoro.cli.documentation.searching import find_items, known_names, related_to  # noqa: PLC0415 - the same

    found = find_items(libraries, name)
    if not found:
        known = known_names(libraries)
        short = (each.rpartition(".")[2] for each in known)
        hint = near(name, [*known, *short, *(each.name for each in libraries)])
        raise UsageError(f"unknown library or symbol `{name}`", help=hint or "`seoro doc` lists the libraries")
    page = _page()
    if as_json:
        _print_json([plain(item) for item in found])
    elif len(found) > _MANY:
        print(page.listed(found))
    else:
        print("\n\n".join(page.item(item, related_to(item, libraries)) for item in found))


def _page() -> Page:
    from seoro.cli.documentation.text import Page  # noqa: PLC0415 - parser and checks

    return Page(terminal_columns(), colour=use_colour(sys.stdout))


def _print_json(value: object) -> None:
    print(json.dumps(value, indent=1, ensure_ascii=False))
