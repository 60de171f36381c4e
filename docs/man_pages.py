"""Write manual pages of all commands from their options: `python docs/man_pages.py FOLDER`, or `make man`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from argparse_manpage.manpage import Manpage

from seoro import __version__
from seoro.cli.arguments import actions_of
from seoro.cli.commands import COMMANDS
from seoro.cli.main import command_parser


def page_of(name: str | None) -> str:
    """Return the page of a command in the format of `man`; that of `seoro` itself for None."""
    parser = command_parser([] if name is None else [name])
    if name is not None:
        [commands] = (each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
        parser = commands.choices[name]
    for action in actions_of(parser):
        if isinstance(action.metavar, tuple):  # argparse-manpage expects one word
            action.metavar = " ".join(action.metavar)
    data = {"project_name": "seoro", "version": __version__, "manual_title": "seoro manual"}
    if name is not None:
        data["description"] = COMMANDS[name]
    page = Manpage(parser, data, format="single-commands-section")
    page.prog = parser.prog.replace(" ", "-")
    page.mf._prog = page.prog
    return str(page)


def main(folder: Path) -> None:
    """Write `seoro.1`, and `seoro-COMMAND.1` for each command."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "seoro.1").write_text(page_of(None))
    for name in COMMANDS:
        (folder / f"seoro-{name}.1").write_text(page_of(name))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
