"""Entry point: warnings about the entry file of a check."""

from __future__ import annotations

from collections.abc import Iterator, Set

from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic, Severity
from seoro.lang.diagnostics.suspicious import OPTIONAL
from seoro.lang.lint.flow import suspicious_members
from seoro.lang.lint.names import shadowing_names, unused_imports, unused_labels, unused_members
from seoro.lang.lint.noqa import apply_suppressions
from seoro.lang.lint.words import read_words
from seoro.lang.projects import settings_around
from seoro.lang.symbols import Kind


def with_lints(checked: Checked, wanted: Set[str] = frozenset()) -> list[Diagnostic]:
    """Return the diagnostics of a check and the lints; comments and the project may suppress warnings.

    Files with errors have no lints, since names may lack their meaning. Imported files have lints when they are
    checked themselves.

    Args:
        checked: The checked file.
        wanted: Codes that are reported even though they are optional.
    """
    if checked.errors:
        return list(checked.diagnostics)
    lints = sorted(_lints(checked), key=lambda found: found.primary.span.start)
    users = [module.file for module in checked.sources.modules if module.library is None]
    entry = checked.sources.entry.file
    ignored = {*settings_around(entry.path).get("ignore", ()), *(OPTIONAL - wanted)}
    found = apply_suppressions([*checked.diagnostics, *lints], users, entry)
    return [each for each in found if each.severity is Severity.ERROR or each.code not in ignored]


def _lints(checked: Checked) -> Iterator[Diagnostic]:
    sources = checked.sources
    users = [module.file for module in sources.modules if module.library is None]
    words = read_words(users)
    yield from shadowing_names(checked)
    if checked.scenarios:  # else its imports may be for files that import it
        own = words if len(users) == 1 else read_words([sources.entry.file])
        yield from unused_imports(checked, own.counts.keys())
    for symbol in checked.program.behaviors.values():
        if symbol.kind is Kind.SCENARIO and symbol.span.file is sources.entry.file:
            yield from unused_members(checked, symbol, words.counts)
            for part in symbol.parts:
                members = tuple(found for found in part.members if found.span.file is sources.entry.file)
                yield from suspicious_members(checked, symbol, members, words.emitted)
                yield from unused_labels(checked, members)
