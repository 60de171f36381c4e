"""`seoro explain`: explain error codes."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from itertools import groupby

from seoro.cli.arguments import add_option
from seoro.cli.terminal import use_colour
from seoro.errors import UsageError
from seoro.lang.explain import Explanation, explanation, explanations, near_codes

EXAMPLES = """examples:
  seoro explain E0312
  seoro explain                      (lists all codes)
  seoro explain --json E0312"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("codes", metavar="CODE", nargs="*", help="error codes such as E0312 (default: list all)")
    add_option(parser, "--json", "print a JSON list")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    found: Sequence[Explanation] = [_find(code) for code in options.codes] or explanations()
    if options.json:
        print(json.dumps([_to_json(item) for item in found], indent=1))
    elif options.codes:
        _show(found)
    else:
        _list(found)


def _find(code: str) -> Explanation:
    found = explanation(code)
    if found is None:
        hint = near_codes(code) or "`seoro explain` lists all codes"
        raise UsageError(f"unknown code `{code}`", help=hint)
    return found


def _show(found: Sequence[Explanation]) -> None:
    """Print explanations as Markdown, rendered on terminals."""
    if not use_colour(sys.stdout):
        print("\n".join(item.text for item in found), end="")
        return
    from rich.console import Console  # noqa: PLC0415 - slow to load
    from rich.markdown import Markdown  # noqa: PLC0415

    console = Console(highlight=False)
    for item in found:
        console.print(Markdown(item.text, code_theme="ansi_dark"))
        console.print()


def _list(found: Sequence[Explanation]) -> None:
    """Print codes with titles, grouped by phase."""
    bold, plain = ("\x1b[1m", "\x1b[0m") if use_colour(sys.stdout) else ("", "")
    for number, (phase, items) in enumerate(groupby(found, key=lambda item: item.phase)):
        print("\n" * bool(number) + f"{bold}{phase}{plain}")
        for item in items:
            print(f"  {item.code}  {item.title}")


def _to_json(item: Explanation) -> dict[str, object]:
    fields = {name: getattr(item, name) for name in ("code", "phase", "title", "meaning")}
    of_example = ("wrong", "message", "right", *(("files", "right_files") if item.example.files else ()))
    return fields | {name: getattr(item.example, name) for name in of_example}
