"""Parser: runs the automaton of `osc.lark` over the tokens of a file; `build.py` builds the tree.

A word is a keyword where the grammar allows the keyword, and a name elsewhere (7.2.1.5.1); if both are allowed,
the next token decides. An invalid statement is reported and replaced by `INVALID`. Parsing continues with the next
one, so that one run reports the errors of all statements.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from seoro.lang import ast, parse_table
from seoro.lang.automaton import Automaton
from seoro.lang.build import Builder
from seoro.lang.diagnostic import Bag, Diagnostic
from seoro.lang.diagnostics import syntax
from seoro.lang.expected import OPERAND_STARTS, describe, explain
from seoro.lang.habits import foreign_format
from seoro.lang.lexer import LAYOUT, MAX_ERRORS, Lexer, Refused, Token
from seoro.lang.source import SourceFile, Span
from seoro.lang.unread import names_declared

if TYPE_CHECKING:
    from seoro.lang import habit_search

_CALLED = frozenset({"rise", "fall", "elapsed", "every", "sample", "keep", "remove_default", "cover", "record"})
_STATEMENTS = frozenset({"event", "def", "var", "do", "on", "emit", "wait", "call", "until"})
_NAMING = frozenset({"event", "def", "var", "do", "emit"})  # a name follows, no bracket
_COMPOSITIONS = frozenset({"serial", "parallel", "one_of"})
_NAME_GOES_ON = frozenset({"COLON", "COMMA", "DOT", "_ASSIGN"})
_WORD_OPERATORS = frozenset({"in", "and", "or"})
_MARKS_OF_PLACES: Mapping[str, tuple[tuple[str, bool], ...]] = {
    "": (),
    "file": (("SCENARIO", True),),
    "members": (("VAR", True),),
    "behaviors": (("WAIT", True),),
    "reactions": (("CALL", True), ("WAIT", False)),
}  # terminals by place, each with whether statements there can begin with it

_LITERALS: Mapping[str, Callable[[Builder, Span, Token], ast.Expression]] = {
    "INTEGER_LITERAL": Builder.integer_literal,
    "FLOAT_LITERAL": Builder.float_literal,
    "PHYSICAL_LITERAL": Builder.physical_literal,
}  # nodes of numbers by their terminals


def parse_file(file: SourceFile, bag: Bag) -> ast.OscFile:
    """Parse a whole file; errors go to the bag."""
    whole = Span(file, 0, len(file.text))
    kind = foreign_format(file.text)
    if kind:
        bag.add(syntax.foreign_file, _first_line(whole), kind)
        return ast.OscFile((), None, whole)
    parser = _Parser(file, bag)
    tree = _parse(parser, "osc_file", 0)
    return parser.with_unread(tree) if isinstance(tree, ast.OscFile) else ast.OscFile((), None, whole)


def parse_part(file: SourceFile, bag: Bag, start: int, stop: int) -> ast.OscFile | None:
    """Parse some statements of a file; None if they are unparsable.

    Args:
        file: The file.
        bag: Bag for messages.
        start: Offset of the line of the first statement.
        stop: Offset of the line behind the last one, or the length of the text.
    """
    parser = _Parser(file, bag, stop)
    tree = _parse(parser, "osc_file", start)
    return parser.with_unread(tree) if isinstance(tree, ast.OscFile) else None


def parse_expression(file: SourceFile, bag: Bag, offset: int = 0) -> ast.Expression | None:
    """Parse a text that is one expression from `offset`; None if it is invalid."""
    before = len(bag)
    number = Lexer(file, bag).lone_number(offset)
    tree: ast.Expression | None
    if number is None:
        tree = _parse(_Parser(file, bag), "lone_expression", offset)
    else:  # most values of the runs of a campaign; the automaton takes several times as long
        tree = _LITERALS[number.kind](Builder(file, bag), Span(file, number.start, number.end), number)
    return tree if len(bag) == before else None


def _parse(parser: _Parser, start: str, offset: int) -> Any:
    """Return the tree of a start symbol; None if the text is unparsable."""
    try:
        return parser.parse(start, Lexer(parser.file, parser.bag, parser.stop).tokens(offset))
    except Refused as refused:
        parser.bag.put(refused.message)
        return None


def _first_line(whole: Span) -> Span:
    """Return the first line of a text that is not blank."""
    start = len(whole.text) - len(whole.text.lstrip())
    return Span(whole.file, start, start + len(whole.text[start:].partition("\n")[0].rstrip()))


@cache
def _keywords() -> dict[str, str]:
    """Return the terminals of the words that are keywords somewhere."""
    return {text: name for text, name in parse_table.load()["literals"].items() if text[0].isalpha()}


class _Parser(Automaton):
    """One parse: detection of keywords, and recovery from unexpected tokens."""

    def __init__(self, file: SourceFile, bag: Bag, stop: int | None = None) -> None:
        super().__init__(file, Builder(file, bag))
        self.bag = bag
        self.stop = stop
        self._keywords = _keywords()
        self._tokens: list[Token] = []
        self._errors = 0
        self._reported: set[int] = set()  # lines with an error: later ones there are consequences
        self._lost: list[tuple[int, int]] = []  # spans that are not in the tree
        self._lost_from = 0  # start of the span that is being skipped

    def parse(self, start: str, tokens: list[Token]) -> Any:
        """Return the tree of a start symbol; None if the tokens are unparsable.

        Raises:
            Refused: The text exceeds a limit.
        """
        self._tokens = tokens
        self._reported = {found.primary.span.line for found in self.bag.diagnostics}
        self._states = [self._starts[start]]
        self._values = [None]
        self._spans = [(0, 0, 0)]
        accepting = self._gotos[self._starts[start]][start]
        rows, gotos, units = self._rows, self._gotos, self._units
        states, keywords = self._states, self._keywords
        index = 0
        while True:
            token = tokens[index]
            kind = token.kind
            row = rows[states[-1]]
            if kind == "NAME" and token.value in keywords:
                kind = self._kind(index, row)
            elif kind == "$END" and states[-1] == accepting:
                return self._values[-1]
            action = row.get(kind)
            if action is None:
                index = self._recover(index, kind)
                if index < 0:
                    return None
            elif action >= 0:
                self._shift(action, token, kind)
                index += 1
            elif (origin := units[-1 - action]) is not None:
                if kind is token.kind and kind != "NAME":
                    states[-1] = self._after_units(kind)
                else:
                    states[-1] = gotos[states[-2]][origin]
            else:
                self._reduce(-1 - action)

    def _kind(self, index: int, row: dict[str, int]) -> str:
        """Return the terminal of the token at `index`: a keyword or a name, by the parser's state."""
        word = self._tokens[index].value
        keyword = self._keywords[word]
        if keyword not in row:
            return "NAME"
        if "NAME" not in row:
            return keyword
        behind = self._tokens[index + 1]
        if word in _CALLED:
            is_keyword = behind.kind == "LPAR"
        elif word in {"range", "list"}:
            is_keyword = behind.kind == "LPAR" or behind.value == "of"
        elif word in {"as", "is"}:
            is_keyword = behind.kind == "LPAR"
        elif word in {"default", "hard"}:
            is_keyword = behind.kind in OPERAND_STARTS and behind.value not in _WORD_OPERATORS
        elif word in _COMPOSITIONS:
            is_keyword = behind.kind in {"COLON", "LPAR"}
        elif word in _STATEMENTS:
            is_keyword = behind.kind not in _NAME_GOES_ON and not (word in _NAMING and behind.kind == "LPAR")
        else:
            is_keyword = True
        return keyword if is_keyword else "NAME"

    # ------------------------------------------------------------ errors

    def with_unread(self, tree: ast.OscFile) -> ast.OscFile:
        """Add the names that skipped statements may declare to a tree."""
        unread = names_declared(self._tokens, self._lost)
        return tree if unread == () else ast.OscFile(tree.statements, unread, tree.span)

    def _recover(self, index: int, kind: str) -> int:
        """Report the unexpected token at `index`; return the index to resume at, or -1 to stop."""
        self._lost_from = self._tokens[index].start
        index = self._mend(index, kind)
        if index >= 0 and self._lost_from < self._tokens[index].start:
            self._lost.append((self._lost_from, self._tokens[index].start))
        return index

    def _mend(self, index: int, kind: str) -> int:
        tokens, token = self._tokens, self._tokens[index]
        self._errors += 1
        if self._errors > MAX_ERRORS:
            return -1
        if kind == "_INDENT":
            return self._unexpected_block(index)
        if kind == "_NEWLINE" and tokens[index + 1].kind == "_INDENT" and self._accepts("COLON"):
            return self._missing_colon(index)
        if self._accepts("_INDENT"):
            return self._missing_block(index)
        habit = self._habit(index)
        if habit is not None and habit.repair is not None:
            return self._repair(index, habit)
        if habit is None:
            if self._reread_unclosed(index):
                return index
            self._report(index, kind)
        if not self._fresh:
            self._drop_line()
        if not self._feed_invalid(token):
            return -1
        index = self._skip_statement(index)
        while habit is not None and tokens[index].kind == "NAME" and tokens[index].value in habit.habit.tails:
            index = self._skip_statement(index)
        return index

    def _habit(self, index: int) -> habit_search.Found | None:
        """Find and report a habit of another language in the statement at `index`."""
        from seoro.lang import habit_search  # noqa: PLC0415 - for errors only

        first = index if self._fresh else self._first_of_line(index)
        if self._span(self._tokens[first]).line in self._reported:
            return None
        depth = len(self._states) if self._fresh else self._marks[-1]
        found = habit_search.find(self.file, self._tokens, first, index, lambda place: self._stands(place, depth))
        if found is not None:
            self._add(found.message)
            self._reported.add(self._span(self._tokens[first]).line)
        return found

    def _stands(self, place: str, depth: int) -> bool:
        """Return whether statements of a kind of surroundings are allowed at a depth of the stack."""
        return all(self._accepts(word, depth) == is_accepted for word, is_accepted in _MARKS_OF_PLACES[place])

    def _repair(self, index: int, found: habit_search.Found) -> int:
        """Replace the faulty words; return the first index of their statement, to parse it again."""
        first = index if self._fresh else self._first_of_line(index)
        if not self._fresh:
            self._truncate(self._marks[-1])
            self._fresh = True
        start, end = self._tokens[found.first].start, self._tokens[found.behind - 1].end
        text = SourceFile("", found.repair or "")
        words = [token for token in Lexer(text, Bag()).tokens() if token.kind not in LAYOUT]
        for token in words:
            token.start, token.end = start, end
        self._tokens[found.first : found.behind] = words
        return first

    def _add(self, message: Diagnostic) -> None:
        """Report, unless the line has an error already."""
        line = message.primary.span.line
        if line not in self._reported:
            self._reported.add(line)
            self.bag.put(message)

    def _unexpected_block(self, index: int) -> int:
        """Recover from a block below a line that opens none, or lacks its colon."""
        tokens, newline = self._tokens, self._values[-1]
        if isinstance(newline, Token) and newline.kind == "_NEWLINE":
            taken = self._states.pop(), self._values.pop(), self._spans.pop()
            if self._accepts("COLON"):
                tokens.insert(index, newline)
                return self._missing_colon(index)
            self._states.append(taken[0])
            self._values.append(taken[1])
            self._spans.append(taken[2])
        self._add(syntax.unexpected_indentation(self._span(tokens[index + 1])))
        del tokens[self._end_of_block(index)], tokens[index]
        return index

    def _missing_colon(self, index: int) -> int:
        """Put a colon before the end of a line."""
        token = self._tokens[index]
        self._add(syntax.missing_colon(self._span(token)))
        self._tokens.insert(index, Token("COLON", ":", token.start, token.start))
        self._fresh = False
        return index

    def _missing_block(self, index: int) -> int:
        tokens = self._tokens
        here = next((token for token in tokens[index:] if token.kind not in LAYOUT), tokens[-1])
        header = tokens[index - 1]
        while header.kind in LAYOUT and header is not tokens[0]:
            header = tokens[tokens.index(header) - 1]
        line = Span(self.file, self._spans[self._marks[-1]][0], header.end)
        self._add(syntax.missing_block(self._span(here), line))
        self._drop_line()
        return index if self._feed_invalid(tokens[index]) else -1

    def _report(self, index: int, kind: str) -> None:
        tokens, token = self._tokens, self._tokens[index]
        first = index if self._fresh else self._first_of_line(index)
        word = tokens[first].value
        if tokens[first].kind == "NAME" and index - first <= 1 and (place := explain(word)):
            self._add(syntax.misplaced_statement(self._span(tokens[first]), word, "here", place))
            return
        previous = tokens[index - 1] if index > first else None
        expected = {terminal for terminal in self._rows[self._states[-1]] if self._accepts(terminal)}
        found, wanted, hint = describe(token, kind, previous, expected)
        self._add(syntax.unexpected_token(self._span(token), found, wanted, hint))

    def _reread_unclosed(self, index: int) -> bool:
        """Read the line of a token again if an open bracket consumed the line end before it."""
        tokens, token = self._tokens, self._tokens[index]
        opened = self._open_bracket(index)
        if opened is None or self._fresh:
            return False
        line = self.file.position(token.start)[0]
        if token.kind == "_NEWLINE":  # within brackets, a line ends only with the file
            self._add(syntax.unclosed_bracket(self._span(opened), opened.value))
            self._reported.add(line)
            return False
        first = index
        while first > 0 and self.file.position(tokens[first - 1].start)[0] == line:
            first -= 1
        is_statement = tokens[first].kind == "NAME" and bool(explain(tokens[first].value))
        if opened.start >= tokens[first].start or not (first == index or is_statement):
            return False
        self._add(syntax.unclosed_bracket(self._span(opened), opened.value))
        start = tokens[first].start - self.file.position(tokens[first].start)[1] + 1
        levels = self._levels(index)
        self._drop_line()
        if not self._feed_invalid(token):
            return False
        tokens[index:] = Lexer(self.file, Bag(), self.stop).tokens(start, levels)
        return True

    def _open_bracket(self, index: int) -> Token | None:
        """Return the innermost open bracket before the token."""
        opened: list[Token] = []
        for earlier in self._tokens[self._first_of_line(index) : index]:
            if earlier.kind in {"LPAR", "LSQB"}:
                opened.append(earlier)
            elif earlier.kind in {"RPAR", "RSQB"} and opened:
                opened.pop()
        return opened[-1] if opened else None

    def _levels(self, index: int) -> tuple[int, ...]:
        """Return the columns of the open blocks at a token."""
        levels = [0]
        for token in self._tokens[:index]:
            if token.kind == "_INDENT":
                levels.append(token.value)
            elif token.kind == "_DEDENT":
                levels.pop()
        return tuple(levels)

    def _feed_invalid(self, token: Token) -> bool:
        """Replace a statement by `INVALID`, or the enclosing statement if that is not possible."""
        while not self._accepts("INVALID"):
            if len(self._marks) < 2:
                return False
            self._marks.pop()
            self._drop_line()
        while True:
            action = self._rows[self._states[-1]]["INVALID"]
            if action >= 0:
                break
            self._reduce(-1 - action)
        self._states.append(action)
        self._values.append(token)
        self._spans.append((token.start, token.end, 0))
        self._fresh = True
        return True

    def _drop_line(self) -> None:
        """Remove the parsed part of the current statement from the stacks."""
        depth = self._marks[-1]
        if depth < len(self._spans):
            self._lost_from = min(self._lost_from, self._spans[depth][0])
        self._truncate(depth)

    def _skip_statement(self, index: int) -> int:
        """Return the index after the rest of a line and its block."""
        tokens = self._tokens
        while tokens[index].kind not in {"_NEWLINE", "$END"}:
            index += 1
        if tokens[index].kind == "$END":
            return index
        index += 1
        return self._end_of_block(index) + 1 if tokens[index].kind == "_INDENT" else index

    def _end_of_block(self, index: int) -> int:
        """Return the index of the DEDENT that matches the INDENT at `index`."""
        depth = 0
        while True:
            kind = self._tokens[index].kind
            depth += (kind == "_INDENT") - (kind == "_DEDENT")
            if depth == 0:
                return index
            index += 1

    def _first_of_line(self, index: int) -> int:
        while index > 0 and self._tokens[index - 1].kind not in LAYOUT:
            index -= 1
        return index

    def _span(self, token: Token) -> Span:
        return Span(self.file, token.start, token.end)
