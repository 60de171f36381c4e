"""Choice of warnings by code, and fixes of files, for `seoro check`."""

from __future__ import annotations

import argparse
from pathlib import Path

from seoro.cli.files import STDIN
from seoro.cli.rewriting import print_diff, replace_file
from seoro.embed.scenarios import check_file
from seoro.errors import UsageError
from seoro.lang.diagnostic import Diagnostic, Severity
from seoro.lang.explain import codes, near_codes
from seoro.lang.lint.fixes import deletion, without
from seoro.lang.lint.linter import with_lints
from seoro.lang.loader import read_file


def code_set(text: str) -> frozenset[str]:
    """Convert codes that are separated by commas.

    Raises:
        ArgumentTypeError: A code is unknown.
    """
    found = frozenset(code.strip().upper() for code in text.split(","))
    for code in sorted(found):
        if code not in codes():
            hint = near_codes(code) or "`seoro explain` lists all codes"
            raise argparse.ArgumentTypeError(f"unknown code `{code}`: {hint}")
    return found


def is_chosen(found: Diagnostic, options: argparse.Namespace) -> bool:
    """Return whether to report a diagnostic: errors always, warnings by `--select` and `--ignore`."""
    if found.severity is Severity.ERROR:
        return True
    return (options.select is None or found.code in options.select) and found.code not in options.ignore


def fix_file(name: str, options: argparse.Namespace) -> bool:
    """Fix the chosen warnings of a file, or print a diff; return whether it changes.

    The fixed text is checked before it replaces the file.

    Raises:
        UsageError: The file is stdin, or the fixed text would have errors.
    """
    if name == STDIN:
        raise UsageError("`--fix` cannot change stdin")
    path = Path(name)
    before = check_file(path, import_python=False)
    chosen = [
        found for found in with_lints(before.checked, options.select or frozenset()) if is_chosen(found, options)
    ]
    sections = [span for found in chosen if (span := deletion(found)) is not None and span.file is before.file]
    if not sections:
        return False
    text = without(before.file.text, sections)
    after = check_file(path, import_python=False, read=lambda other: text if other == path else read_file(other))
    if after.checked.errors:
        raise UsageError(f"cannot fix {name}: the result would have errors", help="report this scenario")
    if options.diff:
        print_diff(before.file, text)
    else:
        replace_file(path, text)
    return True
