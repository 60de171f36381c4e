"""`seoro check`: parse and check scenario files without running them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence

from seoro.cli.arguments import TEXT, add_option, add_output_format
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, find_files, named_source
from seoro.cli.fixing import code_set, fix_file, is_chosen
from seoro.cli.terminal import use_colour
from seoro.embed.contradictions import find_contradictions
from seoro.embed.scenarios import check_file
from seoro.errors import UsageError
from seoro.lang.diagnostic import Diagnostic, Severity
from seoro.lang.explain import explanations
from seoro.lang.lint.linter import with_lints
from seoro.lang.render import render_text, to_json
from seoro.text.findings import Finding, formatted

EXAMPLES = """examples:
  seoro check maze.osc
  seoro check --strict scenarios/
  seoro check --output-format github scenarios/
  seoro check --fix --ignore E0702,E0703 scenarios/

exit status: 0 without errors, 2 with errors"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="scenario files (.osc), folders with such files, or - for stdin"
    )
    add_output_format(parser)
    add_option(parser, "--strict", "also report extensions to the standard")
    add_option(parser, "--select CODES", "report only these codes of warnings, such as E0704,E0702", type=code_set)
    add_option(
        parser, "--ignore CODES", "do not report these codes of warnings", type=code_set, default=frozenset()
    )
    add_option(parser, "--fix", "delete unused imports and `noqa` comments without effect, then check")
    add_option(parser, "--diff", "with --fix: write nothing, and print a diff")
    add_option(
        parser, "--no-import", "do not import (and thereby run) Python modules of libraries and external methods"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.diff and not options.fix:
        raise UsageError("`--diff` without `--fix`", help="write `seoro check --fix --diff`")
    files = find_files(options.files)
    if options.fix:
        changed = [file for file in files if fix_file(file, options)]
        if options.diff:
            return Exit.FAILED if changed else Exit.PASSED
    checked = _check(files, options)
    found = _once(each for each in checked if is_chosen(each, options))
    if options.output_format != TEXT:
        diagnostics = list(found)
        titles = {each.code: each.title for each in explanations()}
        print(formatted(options.output_format, (Finding(**to_json(each)) for each in diagnostics), titles))
    else:
        diagnostics = _show(found)
        _summarise(len(files), diagnostics)
    return Exit.INVALID if _errors(diagnostics) else Exit.PASSED


def _check(files: Sequence[str], options: argparse.Namespace) -> Iterator[Diagnostic]:
    for file in files:
        path, read = named_source(file)
        scenario = check_file(path, strict=options.strict, import_python=not options.no_import, read=read)
        yield from with_lints(scenario.checked, options.select or frozenset())
        if not options.no_import:  # external methods may decide about constraints
            yield from find_contradictions(scenario)


def _once(diagnostics: Iterator[Diagnostic]) -> Iterator[Diagnostic]:
    """Drop duplicate diagnostics: imported files are checked once per importing file."""
    seen: set[tuple[str, int, int, str, str]] = set()
    for diagnostic in diagnostics:
        span = diagnostic.primary.span
        key = (span.file.name, span.start, span.end, diagnostic.code, diagnostic.message)
        if key not in seen:
            seen.add(key)
            yield diagnostic


def _show(found: Iterator[Diagnostic]) -> list[Diagnostic]:
    """Print diagnostics as they are found."""
    shown: list[Diagnostic] = []
    colour = use_colour(sys.stderr)
    for diagnostic in found:
        print(render_text(diagnostic, colour=colour) + "\n", file=sys.stderr)
        shown.append(diagnostic)
    return shown


def _summarise(files: int, found: Sequence[Diagnostic]) -> None:
    """Print the numbers of files, errors and warnings; on stderr if there are errors."""
    errors = _errors(found)
    warnings = len(found) - errors
    parts = [count(errors, "error") if errors else "no errors"]
    if warnings:
        parts.append(count(warnings, "warning"))
    file = sys.stderr if errors else sys.stdout
    print(f"{count(files)} checked: {', '.join(parts)}", file=file)
    if found:
        print(f"`seoro explain {found[0].code}` explains the {found[0].severity.value}", file=file)


def _errors(found: Sequence[Diagnostic]) -> int:
    return sum(diagnostic.severity is Severity.ERROR for diagnostic in found)
