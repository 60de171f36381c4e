"""Other layouts of a text: the same tokens and comments, differently spaced, indented and broken."""

from __future__ import annotations

import random

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.format.lines import read_lines
from seoro.lang.lexer import Lexer
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile

BLANKS = ("", "", " ", "  ", "\t", " \f ")
ENDS = ("\n", "\r\n", "\r")


def dump(text: str) -> list[object]:
    """Return the tree of a text without positions, as a flat list; the text has no errors."""
    bag = Bag()
    file = SourceFile("test.osc", text)
    found: list[object] = []
    pending: list[object] = [parse_file(file, bag)]
    assert not bag.diagnostics, bag.diagnostics
    while pending:
        value = pending.pop()
        if isinstance(value, ast.Node):
            found.append(type(value).__name__)
            fields: tuple[str, ...] = value.__match_args__
            pending += [getattr(value, field) for field in fields if field != "span"]
        elif isinstance(value, tuple):
            found.append(len(value))
            pending += value
        else:
            found.append(repr(value))
    return found


def shuffle(text: str, seed: int) -> str:
    """Return the text in another layout, with the same tree and more comments."""
    draw = random.Random(seed)
    file = SourceFile("test.osc", text)
    read = read_lines(file, Lexer(file, Bag()).tokens())
    end = draw.choice(ENDS)
    indents = [""]
    out: list[str] = []
    for line in read.lines:
        del indents[line.level + 1 :]
        if line.level == len(indents):
            indents.append(indents[-1] + draw.choice((" ", "  ", "   ", "        ", "\t")))
        above = [comment.text for comment in line.before.comments]
        out += _between(draw, above, end)
        out.append(indents[line.level] + _line(draw, file, line.tokens, line.gaps, end))
    out += _between(draw, [comment.text for comment in read.rest.comments], end)
    return "".join(out)


def _between(draw: random.Random, comments: list[str], end: str) -> list[str]:
    """Return random lines between statements."""
    drawn = [f"#{number} drawn" for number in range(draw.choice((0, 0, 0, 0, 1, 3)))]
    lines = [" " * draw.randrange(12) + comment for comment in (*comments, *drawn)]
    lines += [draw.choice(("", "  ", "\f", "\t")) for _ in range(draw.choice((0, 0, 0, 1, 3)))]
    draw.shuffle(lines)
    return [line + end for line in lines]


def _line(draw: random.Random, file: SourceFile, tokens, gaps, end: str) -> str:  # type: ignore[no-untyped-def]
    """Return a logical line with random breaks at joints and blanks between tokens."""
    depth = 0
    parts: list[str] = []
    for token, gap, behind in zip(tokens, gaps, [*tokens[1:], None], strict=True):
        text = file.text[token.start : token.end]
        parts.append(text)
        depth += token.kind in {"LPAR", "LSQB"}
        depth -= token.kind in {"RPAR", "RSQB"}
        comments = "".join(f"{comment.text}{end if behind else ''}" for comment in gap.comments)
        if comments:
            parts.append(draw.choice(BLANKS) + comments)
        elif behind is not None:
            touches = token.end == behind.start
            stays = text in "+-"  # whether a sign belongs to a number depends on it
            parts.append(" " * (not touches) if stays else _gap(draw, touches, bool(depth), end))
    comment = draw.choice(("", "", "", " # drawn", "#")) if not gaps[-1].comments else ""
    return "".join(parts) + draw.choice(BLANKS) + comment + end


def _gap(draw: random.Random, touches: bool, in_brackets: bool, end: str) -> str:
    kind = draw.randrange(30)
    if kind == 0 and in_brackets:
        return f" # drawn{end}"
    if kind == 1 and in_brackets:
        return f"{end}   # drawn{end}"
    if kind < 5 and in_brackets:
        return end + " " * draw.randrange(9)
    if kind == 6:
        return f" \\{end}  "
    return draw.choice(BLANKS) if touches else " " + draw.choice(BLANKS)
