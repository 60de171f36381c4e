"""Tables of words from other languages, with the equivalent in OpenSCENARIO DSL.

`line_habits.py` has the patterns of whole statements.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from io import StringIO
from typing import Final

_TRUE: Final = "booleans are `true` and `false`"
_NULL: Final = "every field has a value: omit the default, and the run chooses or sets it"
_SELF: Final = "write only the name of a field of the own type"
NO_IF: Final = "use `one_of` with a `wait <condition>` in each branch, `on <event>:`, or `? :` in an expression"
_EVENTS: Final = "write it directly after `wait`, `on`, `until` or `is`, without brackets around it"

NAMES: Final[Mapping[str, str]] = {
    **dict.fromkeys(("True", "False", "TRUE", "FALSE", "yes", "no", "on", "off"), _TRUE),
    **dict.fromkeys(("None", "none", "null", "NULL", "nil", "nullptr", "undefined"), _NULL),
    **dict.fromkeys(("self", "this"), _SELF),
    **dict.fromkeys(("NaN", "NAN"), "write `nan`"),
    **dict.fromkeys(("Inf", "infinity", "INFINITY"), "write `inf`"),
    **dict.fromkeys(
        ("math", "pi", "PI", "M_PI"), "write the number: `3.141592653589793`, or an angle as `180deg`"
    ),
}
"""Help for unknown names in expressions."""

TYPES: Final[Mapping[str, str]] = {
    **dict.fromkeys(("double", "real", "float32", "float64", "Float", "number"), "the type is `float`"),
    **dict.fromkeys(("str", "String", "char", "text"), "the type is `string`"),
    **dict.fromkeys(("boolean", "Bool", "Boolean"), "the type is `bool`"),
    **dict.fromkeys(("integer", "Int", "int32", "int64", "long", "short", "Integer"), "the type is `int`"),
    **dict.fromkeys(("unsigned", "uint8", "uint32", "uint64", "size_t", "byte"), "the type is `uint`"),
    **dict.fromkeys(("dict", "map", "object", "Dict"), "declare a `struct` with the fields"),
    **dict.fromkeys(("array", "vector", "tuple", "set", "sequence", "List"), "write `list of <type>`"),
    **dict.fromkeys(("duration", "seconds", "Duration"), "the physical type is `time`, of `import osc.types`"),
    **dict.fromkeys(("distance",), "the physical type is `length`, of `import osc.types`"),
    **dict.fromkeys(("velocity",), "the physical type is `speed`, of `import osc.types`"),
    **dict.fromkeys(("auto", "any", "var", "Any", "void"), "every field has a type: name it"),
}
"""Help for unknown types."""

BEHAVIORS: Final[Mapping[str, str]] = {
    **dict.fromkeys(
        ("keep", "remove_default"),
        "`{}` is a member of the scenario, or of a `with:` block",
    ),
    **dict.fromkeys(("cover", "record", "event", "var"), "`{}` is a member of the scenario"),
    "until": "write `until` below the `with:` of the behavior that it ends",
    "emit": "emit an event without brackets: `emit <event>`",
    "call": "write `call <method>()`",
    **dict.fromkeys(("print", "printf", "echo", "puts", "info"), "write `log(...)`, of `import osc.helpers`"),
    **dict.fromkeys(("sleep", "delay", "pause", "wait_for"), "write `wait elapsed(<time>)`"),
    **dict.fromkeys(
        ("assert", "check", "expect", "require"), "write `wait <condition>`, with a `timeout` below `with:`"
    ),
    **dict.fromkeys(("exit", "quit", "stop"), "write `emit end`, or `emit fail`"),
    **dict.fromkeys(("if", "switch"), NO_IF),
    **dict.fromkeys(
        ("set", "assign"), "change a variable by `increment(...)` or `decrement(...)` of `osc.helpers`"
    ),
}
"""Help for unknown scenarios and actions; `{}` stands for the name."""

METHODS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("elapsed", "rise", "fall", "every"), _EVENTS),
    "sample": "`sample` gives a variable its value: `var x: int = sample(<value>, @<event>, <first value>)`",
    "len": "use the method `size()` of the list",
    "range": "write `[1..3]`, or `range(1, 3)` in an expression",
    **dict.fromkeys(("int", "float", "str", "bool", "string", "uint"), "convert by `.as(<type>)`"),
    **dict.fromkeys(("sqrt", "sin", "cos", "abs", "pow", "exp", "log10"), "declare it as an `external` method"),
}
"""Help for calls in expressions of something that is neither a method nor a struct."""

CHARACTERS: Final[Mapping[str, str]] = {
    ";": "a statement ends with its line",
    "{": "write a block by `:` and indentation",
    "}": "write a block by `:` and indentation",
    "|": "an identifier in bars ends with a second `|`, and `or` is the disjunction",
    "°": "write an angle as `90deg`, a temperature as `20celsius`",
    "π": "write `3.141592653589793`",
    "^": "write a power as a product, `a * a`, and a unit as one name, `mpss`",
    "~": "write `not` for the negation",
    "\\": "continue a line within brackets, or by `\\` at its very end",
}
"""Help for characters that begin no token."""

OPERATORS: Final[Mapping[str, str]] = {
    "&&": "and",
    "&": "and",
    "||": "or",
    "–": "-",  # noqa: RUF001 - the habit itself
    "—": "-",
    "−": "-",  # noqa: RUF001
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "×": "*",  # noqa: RUF001
    "·": "*",
    "÷": "/",
    "…": "..",
    "→": "->",
}
"""Operators of other languages and of typography, and the operators that replace them."""

COMMENTS: Final[Mapping[str, str]] = {"//": r"[^\r\n]*", "/*": r"(?s:.*?)(?:\*/|\Z)"}
"""Signs that begin comments in other languages, and patterns for the rest of the comment."""

MISMATCHES: Final[Mapping[tuple[str, str], str]] = {
    **dict.fromkeys(
        (("int", "float"), ("uint", "float")),
        "write an integer, or convert by `.as(int)`, which takes numbers without a fraction",
    ),
    ("the condition", "time"): "to let time pass, write `wait elapsed({text})`",
    **dict.fromkeys(
        (("the condition", "int"), ("the condition", "uint"), ("the condition", "float")),
        "compare the number, as in `{text} == 3`; to let time pass, write `wait elapsed(<time>)`",
    ),
}
"""Help for values of the wrong type, by their purpose or the expected type, and the found type.

`{text}` stands for the source text of the value.
"""

LITERAL_MISMATCHES: Final[Mapping[tuple[str, str], str]] = {
    **dict.fromkeys(
        (("int", "string"), ("uint", "string"), ("float", "string"), ("bool", "string")),
        "write the value without quotes",
    ),
    **dict.fromkeys(
        (("string", "int"), ("string", "uint"), ("string", "float"), ("string", "bool")), "write it in quotes"
    ),
    **dict.fromkeys((("bool", "int"), ("bool", "uint"), ("bool", "float")), _TRUE),
}
"""Help for literals of the wrong type, by the expected and the found type."""

UNITS: Final[Mapping[str, str]] = {
    "m/s": "mps",
    "km/h": "kph",
    "mi/h": "mph",
    "miles/h": "mph",
    "rad/s": "radps",
    "deg/s": "degps",
    **dict.fromkeys(("m/s2", "m/s²", "m/s/s", "mps2"), "mpss"),
    "kmh": "kph",
    "kmph": "kph",
    "meters": "m",
    "metres": "m",
    "metre": "m",
    "kilometers": "km",
    "secs": "s",
    "seconds": "s",
    "msec": "ms",
    "minutes": "min",
    "mins": "min",
    "hours": "h",
    "degrees": "deg",
    "radians": "rad",
    "°": "deg",
    "º": "deg",
    "°C": "celsius",
    "ft": "feet",
    "in": "inch",
}
"""Other spellings of units, and their names in the standard."""

OPENING_QUOTES: Final = "`“‘„‚«”’"  # noqa: RUF001
CLOSING_QUOTES: Final = "`”’“‘»"  # noqa: RUF001
BLANKS: Final = "\u00a0\u2007\u202f\u2002\u2003\u2009\u200b\u3000\ufeff"
"""Unicode blanks of text copied from documents, which do not separate tokens."""

_LONGEST_QUANTITY: Final = 100  # characters of a number and the first part of its unit
# Compiled on first use: few texts need them.
_XML: Final = r"\s*<(?:\?xml|!--|!DOCTYPE|[A-Za-z][\w:.-]*[\s/>])"
_JSON: Final = r"\s*\{\s*(?:\"|\}|$)"
_YAML: Final = (
    r"(?:\s*#.*\n|\s*\n)*(?:%YAML|---\s*\n|[A-Za-z_][\w-]*:(?: .*)?\n(?:\s*#.*\n|\s*\n)*(?:\s*- |\s*[\w-]+:))"
)
_OWN_LINE: Final = (
    r"(?m)^\s*(?:(?:do|import|scenario|actor|struct|action|enum|keep|wait|emit|var|event)[ (]"
    r"|(?:serial|parallel):)"
)


def _first_word(text: str) -> str:
    """Return the first word outside of comments; empty if the text has no words."""
    for line in StringIO(text):
        words = line.split(None, 1)
        if words and not words[0].startswith("#"):
            return words[0]
    return ""


def foreign_format(text: str) -> str:
    """Detect the format of a text in another language; empty if it may be OpenSCENARIO DSL."""
    first = _first_word(text)
    if first[:1] == "<" and re.match(_XML, text):
        return "an OpenSCENARIO XML file" if "<OpenSCENARIO" in text[:4096] else "an XML file"
    if first[:1] == "{" and re.match(_JSON, text):
        return "a JSON file"
    if (first[:1] in "%-" or first.endswith(":")) and re.match(_YAML, text) and not re.search(_OWN_LINE, text):
        return "a YAML file"
    return ""


def compound_unit(text: str, start: int, end: int) -> tuple[int, str]:
    """Return the start of a quantity whose unit is a quotient, such as `3m/s`, and its unit; (-1, "") if none.

    Args:
        text: The text of the file.
        start: Start of the name after the `/`.
        end: End of the name.
    """
    if text[max(0, start - 1) : start] != "/":
        return -1, ""
    line = max(text.rfind("\n", 0, start) + 1, start - _LONGEST_QUANTITY)
    found = re.search(r"(?<![\w.])[0-9][0-9.]*([A-Za-z]\w*/)$", text[line:start])
    return (line + found.start(1), found[1] + text[start:end]) if found else (-1, "")


def mismatch_help(context: str, expected: str, found: str, text: str) -> str:
    """Return help for a value of the wrong type; empty without an entry in the tables.

    Args:
        context: Purpose of the value.
        expected: Expected type.
        found: Type of the value.
        text: Source text of the value.
    """
    habit = MISMATCHES.get((context, found)) or MISMATCHES.get((expected, found), "")
    if not habit and re.fullmatch(r"([\"']).*\1|[+-]?[\d.]+|true|false", text, re.DOTALL):
        habit = LITERAL_MISMATCHES.get((expected, found), "")
    return habit.replace("{text}", text)
