"""`seoro check`: parse and check scenario files, without running anything."""

from __future__ import annotations

import argparse
import json
import sys

from seoro.cli.exits import Exit
from seoro.cli.output import use_colour
from seoro.embed import check_file
from seoro.lang.diagnostic import Severity
from seoro.lang.render import render_text, to_json

NAME = "check"
HELP = "parse and check scenario files, without running"
EXAMPLES = """examples:
  seoro check maze.osc
  seoro check --strict --format json scenarios/*.osc

exit status: 0 without errors, 2 with"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("files", metavar="FILE", nargs="+", help="scenario files (.osc)")
    parser.add_argument(
        "--format", choices=("text", "json"), default="text", help="how to print what was found (default: text)"
    )
    parser.add_argument("--strict", action="store_true", help="report the use of extensions to the standard")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found = [
        diagnostic
        for file in options.files
        for diagnostic in check_file(file, strict=options.strict).checked.diagnostics
    ]
    errors = sum(diagnostic.severity is Severity.ERROR for diagnostic in found)
    if options.format == "json":
        print(json.dumps([to_json(diagnostic) for diagnostic in found], indent=1))
    else:
        colour = use_colour(sys.stderr)
        for diagnostic in found:
            print(render_text(diagnostic, colour=colour) + "\n", file=sys.stderr)
        if not errors:
            print(f"{len(options.files)} file{'s' if len(options.files) > 1 else ''} checked: no errors")
    return Exit.INVALID if errors else Exit.PASSED
