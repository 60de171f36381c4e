"""Messages of reading and parsing (E0101 to E0140)."""

from __future__ import annotations

from seoro.lang.diagnostic import Severity
from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.escapes import ESCAPES
from seoro.lang.habits import CHARACTERS
from seoro.lang.source import Span


class UnreadableFile(TemplateMessage):
    """An unreadable file."""

    CODE = "E0101"
    TEXT = "cannot read `{name}`: {reason}"

    name: str
    reason: str


class TooLong(TemplateMessage):
    """A statement with more tokens than supported."""

    CODE = "E0101"
    TEXT = "cannot read `{span.file.name}`: a statement has more than {limit:,} words and signs"

    limit: int


class UnknownCharacter(TemplateMessage):
    """A character that starts no token."""

    CODE = "E0110"
    TEXT = "unexpected character {_shown}"
    HELP = "{_habit}"

    @property
    def _shown(self) -> str:
        text = self.span.text
        return f"`{text}`" if text.isprintable() else f"U+{ord(text[0]):04X}"

    @property
    def _habit(self) -> str:
        return CHARACTERS.get(self.span.text, "")


class UnclosedString(TemplateMessage):
    """A string without its closing quotes."""

    CODE = "E0111"
    TEXT = (
        "{_is_long:if}this string is not closed by {quotes}",
        "this string is not closed by {quotes} on its line",
    )
    HELP = ("{_is_long:if}", "write a string over several lines in three quotes")

    quotes: str

    @property
    def _is_long(self) -> bool:
        return len(self.quotes) == 3


class UnclosedBracket(TemplateMessage):
    """An opening bracket without its partner."""

    CODE = "E0112"
    TEXT = "`{bracket}` is not closed"
    LABEL = "opened here"
    HELP = "add the missing `{_closing}`"

    bracket: str

    @property
    def _closing(self) -> str:
        return {"(": ")", "[": "]"}[self.bracket]


class UnknownIndentation(TemplateMessage):
    """A line whose indentation is not that of an enclosing block."""

    CODE = "E0113"
    TEXT = "this indentation matches no enclosing block"
    HELP = (
        "{mixes_tabs:if}the enclosing blocks stand at {_known} columns; a tab goes to the next multiple of 8 "
        "columns, so do not mix tabs and spaces",
        "the enclosing blocks stand at {_known} columns",
    )

    columns: tuple[int, ...]
    mixes_tabs: bool

    @property
    def _known(self) -> str:
        return ", ".join(map(str, self.columns))


class UnexpectedIndentation(TemplateMessage):
    """An indented line where no block begins."""

    CODE = "E0114"
    TEXT = "unexpected indentation"
    LABEL = "no block begins here"
    HELP = "a block begins after a line that ends with `:`"


class MissingBlock(TemplateMessage):
    """A line that ends with `:` without an indented block below it."""

    CODE = "E0115"
    TEXT = "expected an indented block"
    HELP = "indent the lines of the block"
    OTHERS = (("header", "the block of this line is missing"),)

    header: Span


class UnexpectedToken(TemplateMessage):
    """A token that the grammar does not allow in its place."""

    CODE = "E0120"
    TEXT = ("unexpected {found}, expected {_expected}", "unexpected {found}")
    HELP = "{help}"

    found: str
    expected: tuple[str, ...]
    help: str = ""

    @property
    def _expected(self) -> str:
        head = ", ".join(self.expected[:-1])
        return f"{head} or {self.expected[-1]}" if head else "".join(self.expected)


class MisplacedStatement(TemplateMessage):
    """A known statement in the wrong place."""

    CODE = "E0121"
    TEXT = "`{word}` cannot stand {place}"
    HELP = "{help}"

    word: str
    place: str
    help: str = ""


class MissingColon(TemplateMessage):
    """A line that opens a block without a colon."""

    CODE = "E0122"
    TEXT = "missing `:` before the block"
    HELP = "end a line that opens a block with `:`"


class LateImport(TemplateMessage):
    """An import after other statements (7.2.2.1.1)."""

    CODE = "E0123"
    TEXT = "`import` after other statements"
    HELP = "move the imports to the top of the file"


class IntegerOutOfRange(TemplateMessage):
    """An integer that exceeds both `int` and `uint`."""

    CODE = "E0130"
    TEXT = "this integer does not fit into 64 bits"
    HELP = "int holds -9223372036854775808 to 9223372036854775807, uint holds 0 to 18446744073709551615"


class FloatOutOfRange(TemplateMessage):
    """A number that exceeds `float`."""

    CODE = "E0131"
    TEXT = "this number is too large for float"
    HELP = "the largest float is about 1.8e308; infinity is written `inf`"


class MixedArguments(TemplateMessage):
    """A positional argument after a named one."""

    CODE = "E0132"
    TEXT = "positional argument after a named one"
    HELP = "positional arguments come first, then those with a name"


class TooDeep(TemplateMessage):
    """Nesting beyond the limit."""

    CODE = "E0133"
    TEXT = "nested more than {limit} levels deep"
    HELP = "give a part of it a name"

    limit: int


class TooNested(TemplateMessage):
    """Nesting so deep that parsing stops.

    Args:
        limit: About how many of the kind can be nested.
    """

    CODE = "E0133"
    TEXT = "nested too deeply (limit {limit})"
    HELP = "at most {limit} of its kind can be nested; give a part of it a name"

    limit: int


class ForeignSyntax(TemplateMessage):
    """A statement or a sign of another language."""

    CODE = "E0138"
    TEXT = "{text}"
    HELP = "{help}"

    text: str
    help: str


class ForeignFile(TemplateMessage):
    """A file of another format."""

    CODE = "E0139"
    TEXT = "expected OpenSCENARIO DSL, found {kind}"
    HELP = "seoro runs OpenSCENARIO DSL 2.x (`.osc`): write the scenario in it, or choose another file"

    kind: str


class UnknownEscape(TemplateMessage):
    """An unknown escape in a string."""

    CODE = "E0140"
    SEVERITY = Severity.WARNING
    TEXT = "unknown escape `{span.text}` in a string; the backslash is kept"
    HELP = f"write `\\{{span.text}}` for a backslash; escapes are {ESCAPES}"
