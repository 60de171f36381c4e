"""A combination of a sweep as a scenario file of its own, which runs without the sweep.

It is the file of the sweep, with what it imports by a relative path named from its new place, and an extension of
the scenario that fixes what varies.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from seoro.embed import Scenario
from seoro.lang.ast import ImportUri


def emitted(scenario: Scenario, entry: str, values: Mapping[str, str], folder: Path) -> str:
    """The text of a file.

    Args:
        scenario: What is swept.
        entry: The qualified name of the scenario in it.
        values: Of the axes, by path.
        folder: Where the file is going to be.
    """
    parsed = scenario.checked.sources.entry
    home = Path(parsed.file.name).parent
    text = parsed.file.text
    for statement in reversed([each for each in parsed.tree.statements if isinstance(each, ImportUri)]):
        if ":" in statement.uri or Path(statement.uri).is_absolute():
            continue
        uri = os.path.relpath(home / statement.uri, folder)
        span = statement.span
        start = text.index(statement.uri, span.start)
        text = text[:start] + uri + text[start + len(statement.uri) :]
    fixed = "".join(f"    keep({path} == {value})\n" for path, value in values.items())
    return f"{text.rstrip()}\n\nextend {entry}:\n{fixed}" if fixed else text
