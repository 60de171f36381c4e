"""A combination of a sweep as a scenario file of its own, which runs without the sweep.

It is the file of the sweep with one value in place of each list. Files that it imports by a relative path are
named from its new place.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from seoro.embed import Scenario
from seoro.errors import InvalidUse
from seoro.lang.ast import ImportUri
from seoro.lang.loader import Module
from seoro.lang.source import Span
from seoro.sweep.axes import Axis


def emitted(scenario: Scenario, axes: Sequence[Axis], values: Mapping[str, str], folder: Path) -> str:
    """The text of a file.

    Args:
        scenario: What is swept.
        axes: What varies in it.
        values: For the axes, by path.
        folder: Where the file is going to be.

    Raises:
        InvalidUse: A list stands in another file.
    """
    parsed = scenario.checked.sources.entry
    edits = [*_imports(parsed, folder)]
    for axis in axes:
        if axis.span.file is not parsed.file:
            raise InvalidUse(
                f"the values of `{axis.path}` stand in another file, which stays as it is",
                axis.span,
                help="give it a value with `--set`, or a list in the scenario itself",
            )
        edits.append((axis.span, f"[{values[axis.path]}]"))
    text = parsed.file.text
    for span, new in sorted(edits, key=lambda edit: edit[0].start, reverse=True):
        text = text[: span.start] + new + text[span.end :]
    return text


def _imports(parsed: Module, folder: Path) -> Iterator[tuple[Span, str]]:
    """The imports by relative paths, and what stands for them in another folder."""
    home = Path(parsed.file.name).parent
    for statement in parsed.tree.statements:
        if isinstance(statement, ImportUri) and ":" not in statement.uri and not Path(statement.uri).is_absolute():
            uri = os.path.relpath(home / statement.uri, folder)
            yield statement.span, statement.span.text.replace(statement.uri, uri)
