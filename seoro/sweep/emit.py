"""Export of a combination of a sweep as a scenario file.

It is the file of the sweep with one value in place of each list. Relative imports are adapted to its folder.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from seoro.embed import Scenario
from seoro.errors import UsageError
from seoro.lang.ast import ImportUri
from seoro.lang.loader import Module
from seoro.lang.source import Span
from seoro.sweep.axes import Axis


def emitted(scenario: Scenario, axes: Sequence[Axis], values: Mapping[str, str], folder: Path) -> str:
    """Make the text of a scenario file.

    Args:
        scenario: Scenario of the sweep.
        axes: Axes of the sweep.
        values: Values of the axes, by path.
        folder: Folder of the new file.

    Raises:
        UsageError: A list of values is in another file.
    """
    parsed = scenario.checked.sources.entry
    edits = [*_imports(parsed, folder)]
    for axis in axes:
        if axis.span.file is not parsed.file:
            raise UsageError(
                f"the values of `{axis.path}` are in another file, which cannot be changed",
                axis.span,
                help="set a value with `--set`, or list values in the scenario itself",
            )
        edits.append((axis.span, f"[{values[axis.path]}]"))
    text = parsed.file.text
    for span, new in sorted(edits, key=lambda edit: edit[0].start, reverse=True):
        text = text[: span.start] + new + text[span.end :]
    return text


def _imports(parsed: Module, folder: Path) -> Iterator[tuple[Span, str]]:
    """Yield the relative imports with their text for another folder."""
    home = Path(parsed.file.name).parent
    for statement in parsed.tree.statements:
        if isinstance(statement, ImportUri) and ":" not in statement.uri and not Path(statement.uri).is_absolute():
            uri = os.path.relpath(home / statement.uri, folder)
            yield statement.span, statement.span.text.replace(statement.uri, uri)
