"""Lexer (7.2.1): logical lines, indentation, literals, words and operators.

All words are `NAME` tokens; the parser decides by context which are keywords. Indentation follows Python 3.10,
section 2.1.8, with tabs to multiples of 8 columns.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Any, Final, NamedTuple

from seoro.lang import parse_table
from seoro.lang.diagnostic import Bag, Diagnostic
from seoro.lang.diagnostics import syntax
from seoro.lang.escapes import unescape
from seoro.lang.habits import BLANKS, CLOSING_QUOTES, COMMENTS, OPENING_QUOTES, OPERATORS
from seoro.lang.source import SourceFile, Span

TAB_STOP = 8
LAYOUT: Final = frozenset({"_NEWLINE", "_INDENT", "_DEDENT", "$END"})  # terminals without text
MAX_ERRORS = 30  # of one file; later errors are mostly consequences
MAX_TOKENS = 50_000  # of one logical line
# A letter, an underscore or a character beyond ASCII, whose category is checked later; then digits, too.
# The sets exclude the rest of ASCII: sets of Unicode ranges take long to compile.
_NAME = r"(?:[^\x00-@\[-^`{-\x7f][^\x00-/:-@\[-^`{-\x7f]*|\|[^|]+\|)"
# No possessive groups: Python up to 3.11.4 gets them wrong (`*+` of single characters is right).
_TOKEN: Final = re.compile(
    rf"""
      (?P<blank>[ \t\f]+|\\(?:\r\n|\r|\n))
    | (?P<comment>\#[^\r\n]*)
    | (?P<end>\r\n|\r|\n)
    | (?P<wildcard>(?:{_NAME})?::[ \t]*\*)
    | (?P<prefixed>(?:{_NAME})?::{_NAME})
    | (?P<number>0x[0-9A-Fa-f]+|[0-9]*\.[0-9]+(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+|[0-9]+)
      (?P<unit>(?:(?:{_NAME})?::)?{_NAME})?
    | (?P<name>{_NAME})
    | (?P<long>\"\"\"[^\\"]*+(?:(?:\\.|\"(?!\"\"))[^\\"]*+)*\"\"\"|'''[^\\']*+(?:(?:\\.|'(?!''))[^\\']*+)*''')
    | (?P<short>\"(?!\"\")[^\\\r\n\"]*+(?:(?:\\\r\n|\\.)[^\\\r\n\"]*+)*\"
        |'(?!'')[^\\\r\n']*+(?:(?:\\\r\n|\\.)[^\\\r\n']*+)*')
    | (?P<operator>=>|==|!=|<=|>=|->|\.\.|[-+*/%<>=.,:@?()\[\]!])
    """,
    re.VERBOSE | re.DOTALL,
)
_START_CATEGORIES = frozenset({"Ll", "Lm", "Lo", "Lt", "Lu", "Nl"})
_CHAR_CATEGORIES = _START_CATEGORIES | {"Mc", "Mn", "Nd", "Pc"}


class Token:
    """A token: `kind` is its terminal in the grammar; `NAME` for any word."""

    __slots__ = ("end", "kind", "start", "value")

    def __init__(self, kind: str, value: Any, start: int, end: int) -> None:
        self.kind = kind
        self.value = value
        self.start = start
        self.end = end


class Number(NamedTuple):
    """The value of a number's token; `unit` is the text of its unit, with bars and prefix."""

    value: int | float
    is_float: bool
    unit: str | None


class Refused(Exception):
    """Reading of a text stopped; the message has the reason."""

    def __init__(self, message: Diagnostic) -> None:
        super().__init__()
        self.message = message


class Lexer:
    """Reads the tokens of a file.

    Args:
        file: The file.
        bag: Bag for messages.
        stop: Offset of the line at which to stop; default the end of the text.
    """

    def __init__(self, file: SourceFile, bag: Bag, stop: int | None = None) -> None:
        self._file = file
        self._text = file.text[:stop]
        self._bag = bag
        self._errors = 0
        self._operators = parse_table.load()["literals"]
        self._has_braces = False
        self._blanks_line = 0  # the last line with a reported blank

    def tokens(self, offset: int = 0, indents: tuple[int, ...] = (0,)) -> list[Token]:
        """Return all tokens from the start of a line, inside blocks of the given indentations.

        Raises:
            Refused: The text exceeds a limit.
        """
        text, match = self._text, _TOKEN.match
        tokens: list[Token] = []
        levels = list(indents)
        brackets: list[Token] = []
        at_start = True  # of a logical line
        first = 0  # the first token of a logical line
        while offset < len(text):
            if len(tokens) - first > MAX_TOKENS:
                span = Span(self._file, tokens[first].start, offset)
                raise Refused(syntax.too_long(span, MAX_TOKENS))
            if at_start:
                offset, column = self._indentation(offset)
                if text.startswith(("//", "/*"), offset):
                    offset = self._foreign_comment(offset)
                    continue
                found = match(text, offset)
                if found and found.lastgroup in {"comment", "end"}:
                    offset = found.end()
                    continue
                if offset >= len(text):
                    break
                self._indent(tokens, levels, column, offset)
                at_start = False
                first = len(tokens)
            found = match(text, offset)
            if found is None:
                offset = self._recover(tokens, offset)
                continue
            offset = found.end()
            group = found.lastgroup
            if group in {"blank", "comment"}:
                continue
            if group == "name" and (word := found.group()).isascii() and word[0] != "|":  # most tokens
                tokens.append(Token("NAME", word, offset - len(word), offset))
                continue
            if group == "end":
                if not brackets and len(tokens) == first and self._errors:
                    at_start = True  # the line contained only reported text
                elif not brackets:
                    tokens.append(Token("_NEWLINE", None, found.start(), found.start()))
                    at_start = True
                continue
            offset = self._token(tokens, brackets, found, group or "")
        is_part = len(text) < len(self._file.text)
        end = len(text) if not tokens else tokens[-1].end if is_part else len(text.rstrip())
        if not at_start:
            tokens.append(Token("_NEWLINE", None, end, end))
        tokens += [Token("_DEDENT", None, end, end) for _ in levels[1:]]
        tokens.append(Token("$END", None, len(text), len(text)))
        return tokens

    def lone_number(self, offset: int) -> Token | None:
        """Return the token of a text that is one number from `offset`; None for others."""
        found = _TOKEN.match(self._text, offset)
        is_number = found is not None and found["number"] is not None and found.end() == len(self._text)
        return self._number(found) if found is not None and is_number else None

    def _indentation(self, offset: int) -> tuple[int, int]:
        """Return the offset of a line's first non-blank character, and its column from 0."""
        column = 0
        while offset < len(self._text):
            char = self._text[offset]
            if char == " ":
                column += 1
            elif char == "\t":
                column = (column // TAB_STOP + 1) * TAB_STOP
            elif char in BLANKS:
                offset = self._foreign_blanks(offset)
                column += 1
                continue
            elif char != "\f":
                break
            offset += 1
        return offset, column

    def _indent(self, tokens: list[Token], levels: list[int], column: int, offset: int) -> None:
        """Add INDENT and DEDENT tokens before a line."""
        if column > levels[-1]:
            levels.append(column)
            tokens.append(Token("_INDENT", column, offset, offset))
            return
        end = tokens[-1].end if tokens else offset
        while column < levels[-1]:
            inner = levels.pop()
            if column > levels[-1]:  # between two levels: use the inner one
                start = max(self._text.rfind("\n", 0, offset), self._text.rfind("\r", 0, offset)) + 1
                blanks = self._text[start:offset]
                mixes = "\t" in blanks or "\t" in self._file.line(self._file.position(end)[0])[: inner or 1]
                columns = tuple(dict.fromkeys((*levels, inner)))
                self._report(syntax.unknown_indentation(Span(self._file, start, offset), columns, mixes))
                levels.append(inner)
                return
            tokens.append(Token("_DEDENT", column, end, end))

    def _token(self, tokens: list[Token], brackets: list[Token], found: re.Match[str], group: str) -> int:
        """Add the matched token; return the offset after it."""
        start, end = found.span()
        text = found.group()
        if group == "operator":
            if text == "/" and self._text[start : start + 2] in COMMENTS:
                return self._foreign_comment(start)
            token = Token(self._operators[text], text, start, end)
            if text in "([":
                brackets.append(token)
            elif text in ")]" and brackets:
                brackets.pop()
        elif group == "name":
            end = self._end_of_name(start, end)
            if end == start:
                return self._recover(tokens, start)
            token = Token("NAME", text[: end - start], start, end)
        elif group == "prefixed":
            token = Token("PREFIXED", text, start, end)
        elif group == "wildcard":
            token = Token("WILDCARD", text, start, end)
        elif group in {"long", "short"}:
            quotes = 3 if group == "long" else 1
            token = Token("STRING_LITERAL", unescape(text[quotes:-quotes]), start, end)
        else:
            token = self._number(found)
        tokens.append(token)
        return end

    def _number(self, found: re.Match[str]) -> Token:
        digits, unit = found["number"], found["unit"]
        is_hex = digits.startswith("0x")
        is_float = not is_hex and not digits.isdigit()
        start, end = found.span()
        span = Span(self._file, start, found.end("number"))
        value: int | float = 0
        if is_float:
            value = float(digits)
            if value == float("inf"):
                self._report(syntax.float_out_of_range(span))
        elif len(digits) > 30 and len(digits.lstrip("0x")) > 20:  # far out of range, and slow to convert
            self._report(syntax.integer_out_of_range(span))
        else:
            value = int(digits, 16 if is_hex else 10)
            if value >= 2**64:
                self._report(syntax.integer_out_of_range(span))
                value = 0
        kind = "PHYSICAL_LITERAL" if unit else "FLOAT_LITERAL" if is_float else "INTEGER_LITERAL"
        return Token(kind, Number(value, is_float, unit), start, end)

    def _end_of_name(self, start: int, end: int) -> int:
        """Return the end of a word; the category decides about non-ASCII characters (7.2.1.5.1)."""
        text = self._text[start:end]
        if text.isascii() or text.startswith("|"):
            return end
        for index, char in enumerate(text):
            if not char.isascii():
                categories = _CHAR_CATEGORIES if index else _START_CATEGORIES
                if unicodedata.category(char) not in categories:
                    return start + index
        return end

    def _report(self, message: Diagnostic) -> None:
        """Report an error; stop reading after `MAX_ERRORS`."""
        self._errors += 1
        if self._errors >= MAX_ERRORS:
            raise Refused(message)
        self._bag.put(message)

    def _recover(self, tokens: list[Token], offset: int) -> int:
        """Report an invalid token; return the offset to resume at."""
        text = self._text
        char = text[offset]
        if char in "\"'":
            return self._unclosed(tokens, offset)
        if char in BLANKS:
            return self._foreign_blanks(offset)
        if char in OPENING_QUOTES:
            return self._foreign_quotes(tokens, offset)
        sign = next((sign for sign in OPERATORS if text.startswith(sign, offset)), None)
        if sign is not None:
            return self._foreign_operator(tokens, offset, sign)
        if char != "}" or not self._has_braces:  # belongs to a reported brace
            self._report(syntax.unknown_character(Span(self._file, offset, offset + 1)))
        self._has_braces |= char == "{"
        return offset + 1

    def _unclosed(self, tokens: list[Token], offset: int) -> int:
        """Read an unclosed string, which ends with its line or the text."""
        text = self._text
        quotes = text[offset] * 3 if text.startswith(text[offset] * 3, offset) else text[offset]
        ends = [text.find(end, offset) for end in "\r\n"] if len(quotes) == 1 else []
        end = min((found for found in ends if found >= 0), default=len(text))
        self._report(syntax.unclosed_string(Span(self._file, offset, end), quotes))
        tokens.append(Token("STRING_LITERAL", "", offset, end))
        return end

    def _foreign_quotes(self, tokens: list[Token], offset: int) -> int:
        """Read a string in typographic quotes, which ends at the next quotes on its line."""
        char = self._text[offset]
        hint = "quote strings by `\"` or `'`"
        self._report(
            syntax.foreign_syntax(Span(self._file, offset, offset + 1), f"unexpected quotes `{char}`", hint)
        )
        end = offset + 1
        while end < len(self._text) and self._text[end] not in f"\"'\r\n{CLOSING_QUOTES}":
            end += 1
        is_closed = end < len(self._text) and self._text[end] not in "\r\n"
        tokens.append(Token("STRING_LITERAL", self._text[offset + 1 : end], offset, end + is_closed))
        return end + is_closed

    def _foreign_operator(self, tokens: list[Token], offset: int, sign: str) -> int:
        """Replace an operator of another language by its equivalent."""
        own, end = OPERATORS[sign], offset + len(sign)
        span = Span(self._file, offset, end)
        self._report(syntax.foreign_syntax(span, f"unknown operator `{sign}`", f"write `{own}`"))
        tokens.append(Token("NAME" if own.isalpha() else self._operators[own], own, offset, end))
        return end

    def _foreign_comment(self, offset: int) -> int:
        """Skip a comment of another language; return the offset after it."""
        sign = self._text[offset : offset + 2]
        span = Span(self._file, offset, offset + 2)
        before = self._text[self._text.rfind("\n", 0, offset) + 1 : offset]
        is_behind = bool(before.strip()) and sign == "//"
        hint = "begin a comment with `#`" + (", and write a division as `/`" if is_behind else "")
        self._report(syntax.foreign_syntax(span, f"unexpected `{sign}`", hint))
        found = re.compile(COMMENTS[sign]).match(self._text, offset)
        return found.end() if found else offset + 2

    def _foreign_blanks(self, offset: int) -> int:
        """Skip an invalid blank, reported once per line; return the offset after it."""
        line = self._file.position(offset)[0]
        if line != self._blanks_line:
            self._blanks_line = line
            char = self._text[offset]
            name = unicodedata.name(char, "a blank").lower()
            text = f"unexpected blank U+{ord(char):04X} ({name})"
            span = Span(self._file, offset, offset + 1)
            self._report(syntax.foreign_syntax(span, text, "indent and separate words by spaces"))
        return offset + 1
