"""Reader of the parse table, which `grammar.py` generates from the grammar."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

TABLE = Path(__file__).with_name("osc.json")
SPLICED = 1000  # added in a pick to the index of a list whose items become children


class Table(TypedDict):
    """An LALR(1) table.

    `rules` has `[production, length, pick, kind, callback]`. `pick` lists the children of the tree; `None` is an
    absent optional part. `kind` is `node`, `only` (a single child replaces the node) or `list` (its children
    become those of the parent). In `rows`, a number of 0 or more shifts to that state; a negative one reduces by
    rule `-1 - number`. `actions` has the row of each state; equal states share a row.
    """

    grammar: str
    literals: dict[str, str]
    starts: dict[str, int]
    rules: list[list[Any]]
    rows: list[dict[str, int]]
    actions: list[int]
    gotos: list[dict[str, int]]


@cache
def load() -> Table:
    """Load the table."""
    table: Table = json.loads(TABLE.read_text(encoding="utf-8"))
    return table
