"""Parsing again after an edit equals parsing the whole text."""

from __future__ import annotations

import random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.lang import ast, parser
from seoro.lang.diagnostic import Bag
from seoro.lang.incremental_parser import IncrementalParser
from seoro.lang.source import SourceFile, Span
from tests.lang.fuzzing import mutate_once, seeds

BODY = """import osc.types
# A comment.
struct box:
    size: length = 2m  # how long
    note: string = "a
b"

scenario main:
    item: box
    do serial:
        wait elapsed(1s)
        emit end
# The end.
"""


def dump(value: Any) -> Any:
    """Return a tree as nested tuples, with the positions of all nodes."""
    if isinstance(value, Span):
        return value.start, value.end, value.file.text
    if isinstance(value, tuple):
        return tuple(map(dump, value))
    if isinstance(value, ast.Node):
        names: tuple[str, ...] = type(value).__match_args__
        kind = ast.DoDirective if isinstance(value, ast.DoDirective) else type(value)
        return kind, *(dump(getattr(value, name)) for name in names)
    return repr(value)  # a number may be nan


def check_equal(parser_: IncrementalParser, text: str) -> None:
    """Compare the tree of the incremental parser with that of `parse_file`."""
    file, bag, whole = SourceFile("a.osc", text), Bag(), Bag()
    tree = parser_.parse(file, bag)
    assert dump(tree) == dump(parser.parse_file(file, whole))
    assert sorted(map(repr, bag.diagnostics)) == sorted(map(repr, whole.diagnostics))
    assert [found.position for found in sorted(bag.diagnostics, key=lambda one: one.position)] == [
        found.position for found in sorted(whole.diagnostics, key=lambda one: one.position)
    ]


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**48))
def test_parsing_after_edits_equals_parsing_the_whole_text(seed: int) -> None:
    chance = random.Random(seed)
    texts = seeds()
    text = chance.choice(texts)
    edited = IncrementalParser()
    check_equal(edited, text)
    for _ in range(4):
        other = mutate_once(text, texts, chance)
        check_equal(edited, other)
        text = chance.choice((text, other))
