"""The parse table that `grammar.py` generated from the grammar, as the parser reads it."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

TABLE = Path(__file__).with_name("osc.json")
SPLICED = 1000  # in a pick: the child at index - SPLICED is a list, whose items are taken


class Table(TypedDict):
    """An LALR(1) table.

    `rules` has `[production, length, pick, kind, callback]`: `pick` says which children reach the tree (None
    for an optional part that is absent), `kind` is `node`, `only` (a node unless there is exactly one child,
    which then stands for it) or `list` (its children become those of the parent). In `actions`, a number of 0
    or more shifts to that state, a negative one reduces by rule `-1 - number`; states with equal rows share
    them.
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
    """The table that belongs to the grammar."""
    table: Table = json.loads(TABLE.read_text(encoding="utf-8"))
    return table
