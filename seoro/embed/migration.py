"""Migration of a scenario file: rewritings until none applies, and the remaining errors."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from seoro.embed.scenarios import Scenario, check_file
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics.bindings import ONLY_DECLARED
from seoro.lang.frozen import Value
from seoro.lang.loader import Reader, Unreadable, read_file
from seoro.lang.migration.edits import Rewriting, apply_edits
from seoro.lang.migration.notes import Note, notes_of
from seoro.lang.migration.rules import rewriting_of

ROUNDS: Final = 100  # of checks of a file; an error may hide others


class Migrated(Value):
    """Result of a migration.

    Args:
        before: Text of the file.
        text: Its new text.
        rewritings: The changes.
        left: Errors that need a decision, with places in the new text.
        notes: Statements that mean something else than before.
    """

    before: str
    text: str
    rewritings: tuple[Rewriting, ...]
    left: tuple[Diagnostic, ...]
    notes: tuple[Note, ...]


def migrate_file(path: Path, *, import_python: bool = True) -> Migrated:
    """Rewrite the text of a scenario file, without writing the file.

    Args:
        path: The file.
        import_python: Whether to import the Python modules of its libraries.
    """
    scenario = check_file(path, import_python=import_python)
    before = text = scenario.file.text
    rewritings: list[Rewriting] = []
    for _ in range(ROUNDS):
        found = _applicable(scenario)
        if not found:
            break
        rewritings += found
        text = apply_edits(text, [edit for rewriting in found for edit in rewriting.edits])
        scenario = check_file(path, import_python=import_python, read=_reader(path, text))
    diagnostics = scenario.checked.diagnostics
    left = tuple(found for found in diagnostics if found in scenario.checked.errors or found.code == ONLY_DECLARED)
    return Migrated(before, text, tuple(rewritings), left, notes_of(scenario.checked.sources.entry.tree))


def _applicable(scenario: Scenario) -> list[Rewriting]:
    """Return rewritings of the scenario file that do not overlap."""
    found: list[Rewriting] = []
    sections: set[range] = set()
    for error in scenario.checked.errors:
        if error.primary.span.file is not scenario.file:
            continue
        rewriting = rewriting_of(error, scenario.checked)
        if rewriting is None:
            continue
        low, high = min(edit.start for edit in rewriting.edits), max(edit.end for edit in rewriting.edits)
        if all(high < section.start or section.stop < low for section in sections):
            sections.add(range(low, high))
            found.append(rewriting)
    return found


def _reader(path: Path, text: str) -> Reader:
    """Return a reader with a new text for one file."""

    def read(other: Path) -> str | Unreadable:
        return text if other == path else read_file(other)

    return read
