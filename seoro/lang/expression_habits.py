"""Patterns of expressions in other languages, with the equivalent in OpenSCENARIO DSL."""

from __future__ import annotations

from typing import Final

from seoro.lang.habit import Habit

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
