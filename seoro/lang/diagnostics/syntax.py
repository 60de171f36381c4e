"""Messages of reading and parsing (E01)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error, warning
from seoro.lang.escapes import ESCAPES
from seoro.lang.frozen import Frozen
from seoro.lang.habits import CHARACTERS
from seoro.lang.source import Span


class UnreadableFile(Frozen):
    """A file cannot be read."""

    span: Span
    name: str
    reason: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0101", self.span, f"cannot read `{self.name}`: {self.reason}")


class UnknownCharacter(Frozen):
    """A character that starts no token."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = self.span.text
        shown = f"`{text}`" if text.isprintable() else f"U+{ord(text[0]):04X}"
        return error("E0110", self.span, f"unexpected character {shown}", help=CHARACTERS.get(text, ""))


class OtherLanguage(Frozen):
    """A statement or a sign as another language has it."""

    span: Span
    text: str
    help: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0138", self.span, self.text, help=self.help)


class UnknownEscape(Frozen):
    """An escape of a string that stands for nothing."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        escape = self.span.text
        hint = f"write `\\{escape}` for a backslash; escapes are {ESCAPES}"
        return warning(
            "E0140", self.span, f"unknown escape `{escape}` in a string; the backslash is kept", help=hint
        )


class ForeignFile(Frozen):
    """A file of another format."""

    span: Span
    kind: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "seoro runs OpenSCENARIO DSL 2.x (`.osc`): write the scenario in it, or choose another file"
        return error("E0139", self.span, f"this is {self.kind}, not OpenSCENARIO DSL", help=hint)


class UnclosedString(Frozen):
    """A string without its closing quotes."""

    span: Span
    quotes: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        if len(self.quotes) == 3:
            return error("E0111", self.span, f"this string is not closed by {self.quotes}")
        hint = "a string over several lines is written in three quotes"
        return error("E0111", self.span, f"this string is not closed by {self.quotes} on its line", help=hint)


class UnclosedBracket(Frozen):
    """An opening bracket without its partner."""

    span: Span
    bracket: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        closing = {"(": ")", "[": "]"}[self.bracket]
        hint = f"add `{closing}` at the end of what it holds"
        return error("E0112", self.span, f"`{self.bracket}` is not closed", label="opened here", help=hint)


class UnknownIndentation(Frozen):
    """A line goes back to an indentation that no enclosing block has."""

    span: Span
    columns: tuple[int, ...]
    mixes_tabs: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        known = ", ".join(str(column) for column in self.columns)
        hint = f"the enclosing blocks stand at {known} columns"
        if self.mixes_tabs:
            hint += "; a tab goes to the next multiple of 8 columns, so do not mix tabs and spaces"
        return error("E0113", self.span, "this indentation matches no enclosing block", help=hint)


class UnexpectedIndentation(Frozen):
    """A line is indented although no block begins."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "a block begins after a line that ends with `:`"
        return error("E0114", self.span, "unexpected indentation", label="no block begins here", help=hint)


class MissingBlock(Frozen):
    """A line ends with `:`, but no indented block follows."""

    span: Span
    header: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        opened = Label(self.header, "it would belong to this line")
        return error(
            "E0115", self.span, "expected an indented block", opened, help="indent the lines of the block"
        )


class UnexpectedToken(Frozen):
    """Something that the grammar does not allow where it stands."""

    span: Span
    found: str
    expected: tuple[str, ...]
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        wanted = ""
        if self.expected:
            head = ", ".join(self.expected[:-1])
            wanted = f", expected {head} or {self.expected[-1]}" if head else f", expected {self.expected[0]}"
        return error("E0120", self.span, f"unexpected {self.found}{wanted}", help=self.help)


class MisplacedStatement(Frozen):
    """A statement that exists, but not in this place."""

    span: Span
    word: str
    place: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0121", self.span, f"`{self.word}` cannot stand {self.place}", help=self.help)


class MissingColon(Frozen):
    """A line that opens a block lacks its colon."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0122", self.span, "missing `:` before the block", help="a line that opens a block ends with `:`"
        )


class LateImport(Frozen):
    """An import after other statements (7.2.2.1.1)."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "imports come before all other statements of a file"
        return error("E0123", self.span, "`import` after other statements", help=hint)


class IntegerOutOfRange(Frozen):
    """A number that neither int nor uint can hold."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "int holds -9223372036854775808 to 9223372036854775807, uint holds 0 to 18446744073709551615"
        return error("E0130", self.span, "this integer does not fit into 64 bits", help=hint)


class FloatOutOfRange(Frozen):
    """A number that float cannot hold."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "the largest float is about 1.8e308; infinity is written `inf`"
        return error("E0131", self.span, "this number is too large for float", help=hint)


class MixedArguments(Frozen):
    """A positional argument after a named one."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "positional arguments come first, then those with a name"
        return error("E0132", self.span, "positional argument after a named one", help=hint)


class TooDeep(Frozen):
    """Nesting beyond what is taken."""

    span: Span
    limit: int

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0133", self.span, f"nested more than {self.limit} levels deep", help="give a part of it a name"
        )


class TooNested(Frozen):
    """Nesting so deep that the file is not read any further."""

    span: Span
    limit: int  # about how many of the kind can stand within each other

    def diagnostic(self) -> Diagnostic:
        """The message."""
        start = Span(self.span.file, self.span.start, self.span.start + 1)
        hint = f"no more than {self.limit} of its kind can stand within each other; give a part of it a name"
        return error("E0133", start, f"nested too deeply (limit {self.limit})", help=hint)


class TooLong(Frozen):
    """A statement of more tokens than are taken."""

    span: Span
    limit: int

    def diagnostic(self) -> Diagnostic:
        """The message."""
        reason = f"a statement has more than {self.limit:,} words and signs"
        return error("E0101", self.span, f"cannot read `{self.span.file.name}`: {reason}")
