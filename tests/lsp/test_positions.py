"""Positions and offsets."""

import pytest
from lsprotocol.types import Position
from pygls.workspace import PositionCodec

from seoro.lang.source import SourceFile, Span
from seoro.lsp.positions import Positions

TEXT = "ab\r\n# \u00e4\U0001f916z\rlast\x0cline"


@pytest.mark.parametrize(
    ("encoding", "character"), [("utf-8", 2 + 2 + 4), ("utf-16", 2 + 1 + 2), ("utf-32", 2 + 1 + 1)]
)
def test_characters_count_in_the_agreed_encoding(encoding: str, character: int) -> None:
    file, positions = SourceFile("x", TEXT), Positions(PositionCodec(encoding))
    offset = TEXT.index("z")
    assert positions.position(file, offset) == Position(1, character)
    assert positions.offset(file, Position(1, character)) == offset


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_positions_of_all_offsets_convert_back(encoding: str) -> None:
    file, positions = SourceFile("x", TEXT), Positions(PositionCodec(encoding))
    for offset in range(len(TEXT) + 1):
        if TEXT[offset - 1 : offset + 1] != "\r\n":
            assert positions.offset(file, positions.position(file, offset)) == offset


def test_a_form_feed_does_not_end_a_line() -> None:
    file = SourceFile("x", TEXT)
    assert Positions(PositionCodec()).position(file, len(TEXT)) == Position(2, 9)


@pytest.mark.parametrize(
    ("position", "offset"),
    [
        (Position(0, 99), 2),
        (Position(1, 99), TEXT.index("z") + 1),
        (Position(99, 0), len(TEXT)),
        (Position(2, 99), len(TEXT)),
    ],
)
def test_positions_outside_of_the_text_become_the_nearest(position: Position, offset: int) -> None:
    assert Positions(PositionCodec()).offset(SourceFile("x", TEXT), position) == offset


def test_an_empty_text_has_one_position() -> None:
    file = SourceFile("x", "")
    assert Positions(PositionCodec()).offset(file, Position(3, 4)) == 0
    found = Positions(PositionCodec()).range(Span(file, 0, 0))
    assert (found.start, found.end) == (Position(0, 0), Position(0, 0))
