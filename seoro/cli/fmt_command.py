"""`seoro fmt`: lay scenario files out after the standard's coding style guide."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from enum import Enum, auto
from pathlib import Path

from seoro.cli.exits import Exit
from seoro.cli.files import STDIN, STDIN_NAME, count, find_files, read_stdin
from seoro.cli.output import print_error, use_colour
from seoro.errors import InvalidScenario, InvalidUse
from seoro.input_files import Kind, read_input, resolved
from seoro.lang.format.fault import LayoutFault
from seoro.lang.loader import read_source
from seoro.lang.source import SourceFile

EXAMPLES = """examples:
  seoro fmt maze.osc scenarios/
  seoro fmt --check --diff scenarios/      (for continuous integration: nothing is written)
  seoro fmt - < maze.osc                   (to stdout)

Only the layout changes: the meaning of a file and its comments stay. A file with syntax errors is left as it
is.

exit status: 0 done, 1 with --check when a file is not laid out so, 2 when a file could not be"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="scenario files (.osc), and folders with such files; - for stdin, which goes to stdout",
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; list the files that would change, and fail if any does",
    )
    parser.add_argument("--diff", action="store_true", help="write nothing; print what would change")


class _Outcome(Enum):
    """What became of a file."""

    CHANGED = auto()
    SAME = auto()
    REFUSED = auto()


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if STDIN in options.files:
        if len(options.files) > 1:
            raise InvalidUse("`-` is the only file where it is given")
        outcomes = [_format_stdin(options)]
    else:
        outcomes = [_format_file(Path(file), options) for file in find_files(options.files)]
        _summarise(outcomes, writes=not (options.check or options.diff))
    if _Outcome.REFUSED in outcomes:
        return Exit.INVALID
    return Exit.FAILED if options.check and _Outcome.CHANGED in outcomes else Exit.PASSED


def _format_stdin(options: argparse.Namespace) -> _Outcome:
    file = SourceFile(STDIN_NAME, read_stdin())
    text = _format(file)
    if text is None:
        return _Outcome.REFUSED
    if options.diff:
        _print_diff(file, text)
    elif not options.check:
        sys.stdout.buffer.write(text.encode())
    return _Outcome.SAME if text == file.text else _Outcome.CHANGED


def _format_file(path: Path, options: argparse.Namespace) -> _Outcome:
    try:
        file = read_source(path)
    except InvalidScenario as error:
        print_error(error)
        print(file=sys.stderr)
        return _Outcome.REFUSED
    text = _format(file)
    if text is None:
        return _Outcome.REFUSED
    if text.encode() == read_input(path, Kind.SCENARIO):  # which may begin with a byte order mark
        return _Outcome.SAME
    if options.diff:
        _print_diff(file, text)
    if options.check:
        print(f"would change {path}", file=sys.stderr)
    elif not options.diff:
        _replace(path, text)
        print(f"changed {path}")
    return _Outcome.CHANGED


def _format(file: SourceFile) -> str | None:
    """The text of a file as it is to be; None, with a message, if it has errors."""
    from seoro.lang.format.formatter import format_text  # noqa: PLC0415 - of no use to other commands

    try:
        return format_text(file)
    except (InvalidScenario, LayoutFault) as error:
        print_error(error)
        print(file=sys.stderr)
        return None


def _replace(path: Path, text: str) -> None:
    """Write a file at once or not at all, with the permissions that it had; a link stays one."""
    path = resolved(path)
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        with new.open("xb") as stream:
            stream.write(text.encode())
            stream.flush()
            os.fsync(stream.fileno())
        new.chmod(path.stat().st_mode & 0o7777)
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _print_diff(file: SourceFile, text: str) -> None:
    for line in _diff(file, text):
        print(line)


def _diff(file: SourceFile, text: str) -> Iterator[str]:
    """The lines of a unified diff, coloured for terminals."""
    from difflib import unified_diff  # noqa: PLC0415 - slow to load, and seldom needed

    colours = {"-": "\x1b[31m", "+": "\x1b[32m", "@": "\x1b[36m"} if use_colour(sys.stdout) else {}
    before = [file.line(number) for number in range(1, file.line_count + 1)]
    after = text.split("\n")
    for line in unified_diff(before, after, file.name, file.name, lineterm=""):
        colour = colours.get(line[:1], "")
        yield f"{colour}{line}\x1b[0m" if colour else line


def _summarise(outcomes: list[_Outcome], *, writes: bool) -> None:
    """Say on stderr what became of how many files."""
    changed, same, refused = (outcomes.count(which) for which in _Outcome)
    parts = [
        f"{count(changed)} {'changed' if writes else 'would change'}" if changed else "",
        f"{count(same)} left as {'it is' if same == 1 else 'they are'}" if same else "",
        f"{count(refused)} could not be formatted" if refused else "",
    ]
    print(", ".join(part for part in parts if part), file=sys.stderr)
