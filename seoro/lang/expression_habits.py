"""Habits of other languages, and the patterns of their expressions, with the equivalent in OpenSCENARIO DSL."""

from __future__ import annotations

from typing import Final

from seoro.lang.frozen import Frozen

FILE, MEMBERS, BEHAVIORS, REACTIONS = "file", "members", "behaviors", "reactions"  # places of a statement
END: Final = "\n"  # end of a line, in the layout of a statement
BLOCK: Final = "\t"  # the beginning of a block


class Habit(Frozen):
    """A statement of another language.

    Args:
        pattern: A regular expression for the words of a statement. Its group `at` is the faulty part.
        message: The message; names of groups in braces are replaced by their matches.
        help: Help text, with the same replacements.
        repair: The words that replace `at`; None if the statement is skipped.
        place: The place in which the habit applies; empty for all.
        meant: Correct words for `{meant}`; the habit applies only if `at` resembles one of them.
        tails: First words of further parts of the same statement, which are skipped with it.
    """

    pattern: str
    message: str
    help: str
    repair: str | None = None
    place: str = ""
    meant: tuple[str, ...] = ()
    tails: tuple[str, ...] = ()


EXPRESSION_HABITS: Final = (
    Habit(
        r".*?(?P<at>!) (?!=)",
        "unexpected `!`",
        "write `not` for the negation; `!` after the name of an enumeration selects a member",
        "not",
    ),
    Habit(
        r".*?(?P<number>\d[\d.]*) (?P<at>%) (?:[,)\]\n]|with)",
        "`%` is the remainder and needs a right operand",
        "{number} percent is `{percent}`",
        "",
    ),
    Habit(
        r".+?(?P<at>if) .+ else .+",
        "unexpected `if` in an expression",
        "write `<condition> ? <value> : <value>`",
    ),
    Habit(r".+?(?P<at>[fFrRbBuU]) \"", "unexpected `{at}` before a string", "strings have no prefix", ""),
    Habit(r".+?(?P<at>\* \*)", "unknown operator `**`", "write a power as a product: `a * a`"),
    Habit(r".+?(?P<at>is not)\b", "unknown operator `is not`", "write `!=`", "!="),
    Habit(r".+?(?P<at>not in)\b", "unknown operator `not in`", "write `not (<value> in <list>)`"),
    Habit(r".+?(?P<at>->) (?=\w)", "unexpected `->`", "access members by `.`", "."),
    Habit(
        r".+?(?P<at>= = =|= = |== =)",
        "unknown operator `{at}`",
        "compare values by `==`",
    ),
    Habit(
        r"(?!(?:scenario|action|actor|struct|modifier|def|event|keep|wait|cover|record|remove_default) |.*\bif )"
        r".*?(?:\w \(|,) (?P<name>\w+) (?P<at>=) (?!=)",
        "unexpected `=` after the name of an argument",
        "write `{name}: <value>`",
        ":",
    ),
    Habit(r".+?(?P<at>< >|= / =|!= =)", "unknown operator `{at}`", "compare values by `!=`", "!="),
    Habit(
        r"(?!def |event |type |unit ).+?(?P<at>is) (?!not\b)(?=[\w\"])",
        "unknown operator `is`",
        "compare values by `==`",
        "==",
    ),
    Habit(
        r".+?(?P<at>(?:list|List|array|vector) (?:\[|<) (?P<type>\w+) (?:\]|>))",
        "unknown type `{at}`",
        "write `list of {type}`",
        "list of {type}",
    ),
    Habit(
        r".+?(?:[=(,:]|\bin) (?P<at>(?P<low>[\w.]+) \.\. (?P<high>[\w.]+)) ",
        "missing brackets around the range `{at}`",
        "write `[{low}..{high}]`",
        "[ {low} .. {high} ]",
    ),
    Habit(
        r".+?\[ (?P<low>[\w.]+) (?P<at>:) (?P<high>[\w.]+) \]",
        "unexpected `:` in a range",
        "write `[{low}..{high}]`",
        "..",
    ),
)
