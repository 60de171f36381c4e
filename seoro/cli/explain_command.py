"""`seoro explain`: what the codes of messages mean."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from itertools import groupby

from seoro.cli.exits import Exit
from seoro.cli.output import use_colour
from seoro.errors import InvalidUse
from seoro.lang.explain import Explanation, explanation, explanations, near_codes

EXAMPLES = """examples:
  seoro explain E0312
  seoro explain                      (lists all codes)
  seoro explain --format json E0312"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("codes", metavar="CODE", nargs="*", help="codes such as E0312; all are listed by default")
    parser.add_argument(
        "--format", choices=("text", "json"), default="text", help="how to print what they mean (default: text)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found: Sequence[Explanation] = [_find(code) for code in options.codes] or explanations()
    if options.format == "json":
        print(json.dumps([_to_json(item) for item in found], indent=1))
    elif options.codes:
        _show(found)
    else:
        _list(found)
    return Exit.PASSED


def _find(code: str) -> Explanation:
    found = explanation(code)
    if found is None:
        hint = near_codes(code) or "`seoro explain` lists all codes"
        raise InvalidUse(f"there is no code `{code}`", help=hint)
    return found


def _show(found: Sequence[Explanation]) -> None:
    """Print explanations: as they are written, or for a terminal."""
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
    """Print codes with their titles, by phase."""
    bold, plain = ("\x1b[1m", "\x1b[0m") if use_colour(sys.stdout) else ("", "")
    for number, (phase, items) in enumerate(groupby(found, key=lambda item: item.phase)):
        print("\n" * bool(number) + f"{bold}{phase}{plain}")
        for item in items:
            print(f"  {item.code}  {item.title}")


def _to_json(item: Explanation) -> dict[str, object]:
    fields: dict[str, object] = {
        "code": item.code,
        "phase": item.phase,
        "title": item.title,
        "meaning": item.meaning,
    }
    example = item.example
    fields |= {"wrong": example.wrong, "message": example.message, "right": example.right}
    return fields if not example.files else {**fields, "files": example.files, "right_files": example.right_files}
