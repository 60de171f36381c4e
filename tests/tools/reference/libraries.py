"""Declarations of the libraries, as `seoro doc` shows them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from seoro.cli.documentation.items import Item, Library
from seoro.cli.documentation.reading import known_libraries, read_libraries
from seoro.cli.documentation.text import DECLARED_ONLY, KINDS, in_order
from tests.tools.reference.tables import code, table

FOLDER: Final = Path(__file__).parents[3] / "seoro"  # without libraries beside it


def libraries() -> str:
    """Return a section for each library."""
    return "\n".join(map(_section, read_libraries(known_libraries(FOLDER), FOLDER)))


def _section(library: Library) -> str:
    parts = [f"## {library.name}\n\n{library.meaning}\n"]
    for kind, items in in_order(library.items):
        rows = [row for item in items for row in (_row(item), *map(_row, item.members))]
        title = KINDS[kind]
        parts.append(f"{title[0].upper()}{title[1:]}:\n\n{table(('declaration', 'meaning'), rows)}")
    return "\n".join(parts)


def _row(item: Item) -> tuple[str, str]:
    return code(f"{item.signature}{' inherits ' + item.inherits if item.inherits else ''}"), " ".join(_about(item))


def _about(item: Item) -> Iterator[str]:
    yield item.meaning
    if item.values:
        title = f"Units, in {item.result}" if item.kind == "type" else "Members"
        yield f"{title}: {', '.join(map(code, item.values))}."
    if not item.is_implemented:
        yield f"*{DECLARED_ONLY}*"
