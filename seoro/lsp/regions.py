"""Region of the cursor: the kind of block, and the part of the statement."""

from __future__ import annotations

from enum import Enum

from seoro.lsp.cursor import Cursor

COMPOSITIONS = frozenset({"serial", "parallel", "one_of"})
TYPES = frozenset({"struct", "actor", "scenario", "action", "modifier", "extend"})


class Region(Enum):
    """Content of a block, or of the file itself."""

    FILE = "declarations"
    MEMBERS = "members of a type"
    BEHAVIORS = "behaviors"
    WITH = "constraints, modifiers and `until`"
    ON = "reactions to an event"


KEYWORDS = {
    Region.FILE: (
        "import", "namespace", "export", "type", "unit", "enum", "struct", "actor", "scenario", "action",
        "modifier", "extend", "global",
    ),
    Region.MEMBERS: (
        "event", "var", "def", "keep", "remove_default", "cover", "record", "on", "do",
    ),
    Region.BEHAVIORS: ("serial", "parallel", "one_of", "wait", "emit", "call", "with"),
    Region.WITH: ("keep", "remove_default", "until"),
    Region.ON: ("emit", "call"),
}  # fmt: skip


def region(cursor: Cursor) -> Region:
    """Return the region of the block around the cursor."""
    if not cursor.parents or cursor.line.column == 0:
        return Region.FILE
    words = cursor.parents[0].words
    if words[0] == "with" or words[-2:] == ("with", ":"):
        return Region.WITH
    if COMPOSITIONS.intersection(words[:4]) and words[0] not in TYPES:
        return Region.BEHAVIORS
    return Region.ON if words[0] == "on" else Region.MEMBERS


def behavior_start(cursor: Cursor) -> int | None:
    """Return the index of the token that begins a behavior or a modifier, or None."""
    words = cursor.line.words
    here = region(cursor)
    if here in {Region.FILE, Region.ON}:
        return None
    first = 1 if here is Region.MEMBERS and words[0] == "do" else 0
    is_labelled = words[first + 1 : first + 2] == (":",) and (here is Region.BEHAVIORS or first == 1)
    return first + 2 if is_labelled else first
