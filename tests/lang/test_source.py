"""Lines and columns of a text."""

from __future__ import annotations

import pytest

from seoro.lang.source import SourceFile, Span


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_lines_end_at_cr_lf_and_both(end: str) -> None:
    file = SourceFile("a.osc", f"one{end}{end}three\f\u2028x{end}")
    assert file.line_count == 4
    assert [file.line(number) for number in (1, 2, 3, 4)] == ["one", "", "three\f\u2028x", ""]
    assert file.position(file.text.index("x")) == (3, 8)


def test_a_span_is_printed_with_its_position() -> None:
    span = Span(SourceFile("a.osc", "one\ntwo"), 4, 7)
    assert (str(span), span.text, span.line, span.column) == ("a.osc:2:1", "two", 2, 1)
    assert span.to(Span(span.file, 6, 7)).text == "two"
