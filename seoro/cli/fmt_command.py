"""`seoro fmt`: format scenario files (coding style guide of the standard)."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from enum import Enum, auto
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import STDIN, STDIN_NAME, count, find_files, read_stdin
from seoro.cli.rewriting import print_diff, replace_file
from seoro.cli.terminal import print_error
from seoro.errors import InvalidScenario, UsageError
from seoro.files.inputs import Kind, read_input
from seoro.lang.format.formatter import LayoutFault, format_text
from seoro.lang.loader import read_source
from seoro.lang.source import SourceFile

EXAMPLES = """examples:
  seoro fmt maze.osc scenarios/
  seoro fmt --check --diff scenarios/      (for continuous integration: writes nothing)
  seoro fmt - < maze.osc                   (to stdout)

Only the layout changes, not the meaning and the comments. Files with syntax errors are not changed.

exit status: 0 done, 1 with --check if a file would change, 2 if a file could not be formatted"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="scenario files (.osc), or folders with such files; - reads stdin and writes stdout",
    )
    add_option(parser, "--check", "write nothing; list files that would change, and exit with 1 if there are any")
    add_option(parser, "--diff", "write nothing; print a diff")


class _Outcome(Enum):
    """Result of formatting a file."""

    CHANGED = auto()
    SAME = auto()
    REFUSED = auto()


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if STDIN in options.files:
        if len(options.files) > 1:
            raise UsageError("`-` cannot be combined with other files")
        outcomes = [_outcome(options, None)]
    else:
        outcomes = [_outcome(options, Path(file)) for file in find_files(options.files)]
        _summarise(outcomes, writes=not (options.check or options.diff))
    if _Outcome.REFUSED in outcomes:
        return Exit.INVALID
    return Exit.FAILED if options.check and _Outcome.CHANGED in outcomes else Exit.PASSED


def _outcome(options: argparse.Namespace, path: Path | None) -> _Outcome:
    """Format a file, or stdin for None; print an error if that fails."""
    try:
        return _format_stdin(options) if path is None else _format_file(path, options)
    except (InvalidScenario, LayoutFault) as error:
        print_error(error)
        print(file=sys.stderr)
        return _Outcome.REFUSED


def _format_stdin(options: argparse.Namespace) -> _Outcome:
    file = SourceFile(STDIN_NAME, read_stdin())
    text = format_text(file)
    if options.diff:
        print_diff(file, text)
    elif not options.check:
        sys.stdout.buffer.write(text.encode())
    return _Outcome.SAME if text == file.text else _Outcome.CHANGED


def _format_file(path: Path, options: argparse.Namespace) -> _Outcome:
    file = read_source(path)
    text = format_text(file)
    if text.encode() == read_input(path, Kind.SCENARIO):  # the bytes may begin with a byte order mark
        return _Outcome.SAME
    if options.diff:
        print_diff(file, text)
    if options.check:
        print(f"would change {path}", file=sys.stderr)
    elif not options.diff:
        replace_file(path, text)
        print(f"changed {path}")
    return _Outcome.CHANGED


def _summarise(outcomes: list[_Outcome], *, writes: bool) -> None:
    """Print the number of files per outcome on stderr."""
    texts = {
        _Outcome.CHANGED: "changed" if writes else "would change",
        _Outcome.SAME: "unchanged",
        _Outcome.REFUSED: "could not be formatted",
    }
    found = Counter(outcomes)
    parts = [f"{count(found[which])} {text}" for which, text in texts.items() if found[which]]
    print(", ".join(parts), file=sys.stderr)
