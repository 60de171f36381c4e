"""Texts with a mark `|` where the cursor stands."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from seoro.lsp.analysis import Analysis, analyse
from seoro.lsp.completion import complete
from seoro.lsp.items import Item

SCENARIO = """import osc.ros
import osc.helpers

enum color: [red, green]

# A box.
# It is heavy.
struct box:
    weight: mass = 3kg
    paint: color = red
    def times(count: int, of: mass = 1kg) -> float is expression count * 1.0

actor crane:
    reach: length = 2m

# Lifts.
action crane.lift:
    what: box
    height: length = 1m

scenario main:
    robot: differential_drive_robot
    crane: crane
    # How fast.
    limit: speed = 60kph
    crate: box
    event go(count: int)
    do parallel:
        first: serial:
            crane.lift(what: crate, height: 2m)
            emit go(count: 3)
            wait @go as occurred if occurred.count > 3
        wait @first.end
"""


def split(text: str) -> tuple[str, int]:
    """Return a text without its mark, and the offset of the mark."""
    offset = text.index("|")
    return text[:offset] + text[offset + 1 :], offset


def analysis(folder: Path, text: str, others: Mapping[str, str] | None = None) -> Analysis:
    """Analyse an unsaved text, with imported ones."""
    texts = {folder.resolve() / name: content for name, content in (others or {}).items()}
    path = folder.resolve() / "test.osc"
    return analyse(path, {**texts, path: text})


def completions(folder: Path, marked: str, before: str | None = SCENARIO) -> dict[str, Item]:
    """Return the completions at the mark, by label.

    Args:
        folder: Folder of the file.
        marked: End of the text, with the mark.
        before: Text before the end, checked last.
    """
    last = [analysis(folder, before or "")]
    text, offset = split((before or "") + marked)
    return {item.label: item for item in complete(text, offset, last).items}
