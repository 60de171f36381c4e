"""`seoro migrate`: rewrite scenario files that were written for scenario_execution."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, find_files
from seoro.cli.rewriting import print_diff, replace_file
from seoro.embed.migration import Migrated, migrate_file
from seoro.lang.render import to_json
from seoro.lang.source import SourceFile
from seoro.text.printable import one_line

EXAMPLES = """examples:
  seoro migrate scenarios/              (list what would change, and what needs a decision)
  seoro migrate --diff scenarios/
  seoro migrate --write scenarios/

Comments and layout are kept. A second run changes nothing. Notes are statements that
mean something else than before, such as `wait` for an event that has already occurred.

exit status: 0 if all files can run now (or would, without --write), 2 if something needs a decision"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="scenario files (.osc), or folders with such files"
    )
    add_option(parser, "--write", "change the files (default: only list the changes)")
    add_option(parser, "--diff", "also print a diff")
    add_option(parser, "--json", "print the result as one JSON object")
    add_option(
        parser, "--no-import", "do not import (and thereby run) Python modules of libraries and external methods"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    results: dict[str, Migrated] = {}
    for file in find_files(options.files):
        results[file] = found = migrate_file(Path(file), import_python=not options.no_import)
        if options.write and found.rewritings:
            replace_file(Path(file), found.text)
        if not options.json:
            _show(file, found, options)
    if options.json:
        print(json.dumps(_as_json(results, wrote=options.write), indent=1))
    else:
        _summarise(results, wrote=options.write)
    return Exit.INVALID if any(found.left for found in results.values()) else Exit.PASSED


def _show(file: str, found: Migrated, options: argparse.Namespace) -> None:
    for rewriting in found.rewritings:
        print(f"{file}:{rewriting.line}: {rewriting.title}")
    if options.diff and found.rewritings:
        print_diff(SourceFile(file, found.before), found.text)
    for error in found.left:
        print(f"{error.primary.span}: needs a decision: {one_line(error.message)} [{error.code}]")
        if error.help:
            print(f"    {one_line(error.help)}")
    for note in found.notes:
        print(f"{note.span}: note: {one_line(note.text)}")


def _as_json(results: Mapping[str, Migrated], *, wrote: bool) -> dict[str, object]:
    files = [
        {
            "file": file,
            "changed": bool(found.rewritings),
            "rewritings": [{"line": each.line, "title": each.title} for each in found.rewritings],
            "decisions": [to_json(error) for error in found.left],
            "notes": [
                {"line": note.span.line, "column": note.span.column, "text": note.text} for note in found.notes
            ],
        }
        for file, found in results.items()
    ]
    return {"written": wrote, "files": files}


def _summarise(results: Mapping[str, Migrated], *, wrote: bool) -> None:
    changed = sum(bool(found.rewritings) for found in results.values())
    undecided = sum(bool(found.left) for found in results.values())
    verb = "rewritten" if wrote else "to rewrite (with --write)"
    fine = len(results) - undecided
    parts = [f"{count(changed)} {verb}", f"{fine} without open decisions", f"{undecided} with"]
    print(", ".join(parts), file=sys.stderr)
