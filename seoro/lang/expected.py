"""Texts of syntax errors in the words of the language: found and expected tokens, and hints for common slips."""

from __future__ import annotations

from typing import Final

from seoro.lang import parse_table
from seoro.lang.lexer import Token

OPERAND_STARTS: Final = frozenset(
    {"NAME", "PREFIXED", "INTEGER_LITERAL", "FLOAT_LITERAL", "PHYSICAL_LITERAL", "STRING_LITERAL", "LPAR", "LSQB"}
)  # operands without keywords and signs
_OPERANDS: Final = OPERAND_STARTS | {"MINUS", "PLUS", "NOT", "IT", "TRUE", "FALSE", "INF", "NAN", "RANGE"}
_RELATIONS: Final = frozenset({"EQUAL", "UNEQUAL", "LESSTHAN", "MORETHAN", "AT_MOST", "AT_LEAST", "IN"})
_OPERATORS: Final = (
    _RELATIONS
    | {"PLUS", "MINUS", "STAR", "SLASH", "PERCENT"}
    | {"AND", "OR", "IMPLIES", "QMARK"}
    | {"DOT", "LPAR", "LSQB", "BANG"}
)
_TYPES: Final = frozenset({"BOOL", "INT", "UINT", "FLOAT", "STRING", "LIST", "RANGE", "NAME", "PREFIXED"})
_NUMBERS: Final = {"INTEGER_LITERAL": "an integer", "FLOAT_LITERAL": "a number", "PHYSICAL_LITERAL": "a quantity"}
_WORDS: Final = {
    "NAME": "a name",
    "STRING_LITERAL": "a string",
    "_NEWLINE": "the end of the line",
    "_INDENT": "an indented block",
    **_NUMBERS,
}
_HIDDEN: Final = frozenset({"INVALID", "_DEDENT", "$END", "PREFIXED", "WILDCARD"})
_MAX_SHOWN = 6

_PLACES: Final = {
    "do": "`do` belongs to scenarios and actions",
    "on": "`on` belongs to scenarios, actions and modifiers",
    "import namespace export type unit enum struct actor action scenario modifier extend global": (
        "write declarations at the left margin, outside of blocks"
    ),
    "event var def keep remove_default cover record": "it is a member of a type",
    "wait emit call serial parallel one_of": "write behavior below the `do` of a scenario",
    "until": "write `until` in the `with:` block of an invocation",
    "with": "a `with:` block belongs to the line above it, at the same indentation as that one",
}


def explain(word: str) -> str:
    """Help on the place of statements that begin with `word`; empty for other words."""
    return next((place for words, place in _PLACES.items() if word in words.split()), "")


def describe(
    token: Token, kind: str, previous: Token | None, expected: set[str]
) -> tuple[str, tuple[str, ...], str]:
    """Return the found token, the expected ones, and a hint.

    Args:
        token: The unexpected token.
        kind: Its terminal.
        previous: The token before it on its line.
        expected: Terminals that the grammar allows here.
    """
    found = {"_NEWLINE": "end of the line", "$END": "end of the file", "_DEDENT": "end of the block"}.get(kind)
    if found is None:
        found = "string" if kind == "STRING_LITERAL" else f"`{_text(token)}`"
    return found, _wanted(expected), _hint(token, kind, previous, expected)


def _text(token: Token) -> str:
    return str(token.value) if isinstance(token.value, str) else "number"


def _wanted(expected: set[str]) -> tuple[str, ...]:
    rest = expected - _HIDDEN
    shown: list[str] = []
    if {"INTEGER_LITERAL", "NOT"} <= rest:
        rest -= _OPERANDS
        shown.append("an expression")
    elif {"LIST", "BOOL"} <= rest:
        rest -= _TYPES
        shown.append("a type")
    if {"STAR", "EQUAL"} <= rest:
        rest -= _OPERATORS
        shown.append("an operator")
    elif {"COLON", "LPAR"} <= rest:
        rest -= {"BANG", "LSQB"}  # a member: a field, or a modifier, whose actor is seldom an element
    literals = {name: text for text, name in parse_table.load()["literals"].items()}
    shown += sorted(_WORDS.get(terminal) or f"`{literals[terminal]}`" for terminal in rest)
    return tuple(shown) if len(shown) <= _MAX_SHOWN else ()


def _hint(token: Token, kind: str, previous: Token | None, expected: set[str]) -> str:
    before = previous.kind if previous is not None else ""
    if kind == "_ASSIGN" and before == "COLON":
        return "write a default after the type: `name: type = value`"
    if kind == "_ASSIGN" and "EQUAL" in expected:
        return "compare values by `==`"
    if kind == "NAME" and before in _NUMBERS and before != "PHYSICAL_LITERAL":
        return "write a unit directly after its number, as in `5m`"
    if kind == "RSQB" and before == "LSQB":
        return "a list has at least one member; a list without a value is empty"
    if kind == "RPAR" and before == "LPAR" and "NOT" in expected:
        return "omit empty brackets"
    if kind == "_ASSIGN" and "COLON" in expected:
        return "name an argument by `name: value`, and declare a field by `name: type = value`"
    if token.value == "inherits" and "OF" in expected:
        return "modifiers do not inherit"
    if kind == "EQUAL" and "_ASSIGN" in expected:
        return "set a default by `=`"
    return ""
