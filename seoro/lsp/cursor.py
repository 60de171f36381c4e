"""Text before the cursor, while it is being written.

Such a text is seldom valid, so this module needs no tree. It splits the tokens of the declaration around the
cursor into lines, and finds blocks by indentation. A letter after the unfinished word at the cursor makes it a
token.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

from seoro.lang.diagnostic import Bag
from seoro.lang.expected import explain
from seoro.lang.lexer import LAYOUT, Lexer, Number, Token
from seoro.lang.source import SourceFile

MARK = "_"  # makes a token of the word or unit before the cursor
_OUTERMOST = re.compile(
    r"^(?:import|namespace|export|type|unit|enum|struct|actor|action|scenario|modifier|extend|global)\b",
    re.MULTILINE,
)
_NAMES = frozenset({"NAME", "PREFIXED"})
_OPENING = frozenset({"LPAR", "LSQB"})
_CLOSING = frozenset({"RPAR", "RSQB"})


@dataclass(frozen=True)
class Line:
    """A logical line.

    Args:
        column: Column of its first character, from 0.
        tokens: Its tokens.
    """

    column: int
    tokens: tuple[Token, ...]

    @cached_property
    def words(self) -> tuple[str, ...]:
        """The texts of its names and operators; empty for other tokens."""
        return tuple(
            token.value if isinstance(token.value, str) and token.kind != "STRING_LITERAL" else ""
            for token in self.tokens
        )


@dataclass(frozen=True)
class Open:
    """A bracket that is open at the cursor.

    Args:
        index: Index of its token in the cursor's line.
        is_call: Whether it contains arguments; otherwise it is a list or a group.
    """

    index: int
    is_call: bool


@dataclass(frozen=True)
class Cursor:
    """A place in a text that is being written.

    Args:
        file: The text before the cursor, with `MARK`.
        line: The cursor's logical line, up to the word at the cursor.
        parents: The lines that open the blocks around it, innermost first.
        word: The part of that word, or unit, before the cursor.
        number: The number whose unit the word is.
    """

    file: SourceFile
    line: Line
    parents: tuple[Line, ...]
    word: str
    number: Number | None

    @property
    def start(self) -> int:
        """Offset of the start of the word."""
        return len(self.file.text) - len(MARK) - len(self.word)

    @cached_property
    def brackets(self) -> tuple[Open, ...]:
        """The open brackets, outermost first."""
        tokens = self.line.tokens
        return tuple(
            Open(index, tokens[index].kind == "LPAR" and index > 0 and tokens[index - 1].kind in _NAMES)
            for index in self._pairs[0]
        )

    @cached_property
    def _pairs(self) -> tuple[list[int], dict[int, int]]:
        """Indices of the open brackets, and those of the others: the opening ones by the closing ones."""
        opened, pairs = list[int](), dict[int, int]()
        for index, token in enumerate(self.line.tokens):
            if token.kind in _OPENING:
                opened.append(index)
            elif token.kind in _CLOSING and opened:
                pairs[index] = opened.pop()
        return opened, pairs

    def receiver(self, end: int) -> int:
        """Return the index of the first token of `a.b(c)[d]` that ends before `end`; `end` without one."""
        tokens = self.line.tokens
        index = end
        while index > 0:
            token = tokens[index - 1]
            if index - 1 in self._pairs[1]:
                index = self._pairs[1][index - 1]
                if tokens[index - 1].kind in _NAMES and index > 0:
                    index -= 1
            elif token.kind in _NAMES or token.kind in {"PHYSICAL_LITERAL", "STRING_LITERAL", "INTEGER_LITERAL"}:
                index -= 1
            else:
                break
            if index == 0 or tokens[index - 1].kind != "DOT":
                return index
            index -= 1
        return index

    def text(self, first: int, end: int) -> str:
        """Return the text of a range of tokens."""
        tokens = self.line.tokens[first:end]
        return self.file.text[tokens[0].start : tokens[-1].end] if tokens else ""


def read_cursor(text: str, offset: int) -> Cursor | None:
    """Read the text before an offset; None within comments and strings, and where no word is possible."""
    file = SourceFile("cursor", text[:offset] + MARK)
    start = 0
    for found in _OUTERMOST.finditer(text, 0, offset):
        start = found.start()
    lines = _lines(file, Lexer(file, Bag()).tokens(start))
    if not lines:
        return None
    line = lines.pop()
    last = line.tokens[-1]
    if last.end != len(file.text) or last.kind not in {*_NAMES, "PHYSICAL_LITERAL"}:
        return None
    number = last.value if isinstance(last.value, Number) else None
    word = (number.unit or "") if number is not None else file.text[last.start : last.end]
    return Cursor(file, line, _parents(lines, line.column), word.removesuffix(MARK), number)


def _lines(file: SourceFile, tokens: list[Token]) -> list[Line]:
    """Split into logical lines; a line that begins like a statement ends the one before, despite open brackets."""
    lines: list[Line] = []
    current: list[Token] = []
    depth = 0
    is_lost = False  # the lexer still counts an abandoned bracket, so it finds no line ends
    for index, token in enumerate(tokens):
        is_end = token.kind in {"_NEWLINE", "$END"}
        if current and not is_end and _is_first(file, token):
            is_cut = depth > 0 and _begins_statement(tokens, index)
            is_lost = is_lost or is_cut
            is_end = is_cut or (is_lost and depth == 0)
        if is_end and current:
            lines.append(Line(_column(file, current[0]), tuple(current)))
            current, depth = [], 0
        if token.kind not in LAYOUT:
            depth = max(0, depth + (token.kind in _OPENING) - (token.kind in _CLOSING))
            current.append(token)
    return lines


def _is_first(file: SourceFile, token: Token) -> bool:
    """Return whether a token is the first of its line."""
    start = max(file.text.rfind("\n", 0, token.start), file.text.rfind("\r", 0, token.start)) + 1
    return not file.text[start : token.start].strip()


def _begins_statement(tokens: list[Token], index: int) -> bool:
    """Return whether a word at the start of a line can only begin a statement."""
    word, behind = tokens[index].value, tokens[index + 1]
    if tokens[index].kind != "NAME" or not explain(word):
        return False
    return behind.kind in {"NAME", "AT", "PREFIXED"} or word in {"serial", "parallel", "one_of"}


def _column(file: SourceFile, token: Token) -> int:
    return file.position(token.start)[1] - 1


def _parents(lines: list[Line], column: int) -> tuple[Line, ...]:
    """Return the lines that open the blocks around a column, innermost first; colons may be missing."""
    found: list[Line] = []
    for line in reversed(lines):
        if line.column < column and (line.tokens[-1].kind == "COLON" or line.column == 0):
            found.append(line)
            column = line.column
    return tuple(found)
