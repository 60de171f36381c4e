"""Roles of the tokens of a line, which determine blanks between them (9.2.2.3)."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from enum import Enum, auto

from seoro.lang import ast
from seoro.lang.lexer import Token
from seoro.lang.tree import find

_NUMBERS = frozenset({"INTEGER_LITERAL", "FLOAT_LITERAL", "PHYSICAL_LITERAL"})
_WORDS = _NUMBERS | {"STRING_LITERAL", "NAME", "PREFIXED", "WILDCARD"}


class Role(Enum):
    """Role of a token."""

    OPERAND = auto()  # names, literals, and keywords directly before an opening bracket
    KEYWORD = auto()  # keywords before an expression
    BINARY = auto()  # an operator between two operands
    SIGN = auto()
    LONE_SIGN = auto()  # a sign that is separate from the number after it
    RANGE = auto()  # the `..` of a range
    OPEN = auto()
    CLOSE = auto()
    COMMA = auto()
    COLON = auto()
    DOT = auto()
    AT = auto()
    BANG = auto()


Level = frozenset[str]
OPERATORS = frozenset({Role.BINARY, Role.KEYWORD})
# Operators at which expressions can be split; operators that bind least come first.
LOGICAL: tuple[Level, ...] = tuple(map(frozenset, (("is",), ("if",), ("?", ":"), ("=>",), ("or",), ("and",))))
ARITHMETIC: tuple[Level, ...] = tuple(
    map(frozenset, (("==", "!=", "<", "<=", ">", ">=", "in"), ("+", "-"), ("*", "/", "%")))
)
SPLITTING = frozenset[str]().union(*LOGICAL, *ARITHMETIC)

_OF_TEXT = {
    "(": Role.OPEN,
    "[": Role.OPEN,
    ")": Role.CLOSE,
    "]": Role.CLOSE,
    ",": Role.COMMA,
    ":": Role.COLON,
    ".": Role.DOT,
    "..": Role.RANGE,
    "@": Role.AT,
    "!": Role.BANG,
}
_KEYWORDS = frozenset(
    {
        "and", "call", "default", "do", "expression", "hard", "if", "in", "is", "not", "on", "only", "or", "until",
        "wait",
    }
)  # fmt: skip
_BEFORE_OPERANDS = frozenset(
    {Role.KEYWORD, Role.BINARY, Role.SIGN, Role.LONE_SIGN, Role.RANGE, Role.OPEN, Role.COMMA, Role.COLON}
)


def find_names(tree: ast.OscFile) -> frozenset[int]:
    """Return the offsets of names, to distinguish them from equal keywords."""
    return frozenset(name.span.start for name in find(tree, ast.Name))


def find_roles(tokens: Sequence[Token], names: Collection[int]) -> list[Role]:
    """Return the roles of the tokens of one logical line.

    Args:
        tokens: The tokens, without those of the layout.
        names: Result of `find_names` for the file.
    """
    roles: list[Role] = []
    end = 0  # end of the previous token
    questions = [0]  # open `?` of ternaries, for each open bracket
    is_export = bool(tokens) and tokens[0].value == "export" and tokens[0].start not in names
    for token in tokens:
        before = roles[-1] if roles else Role.KEYWORD
        role = _role(token, before, names)
        if role is Role.OPEN:
            questions.append(0)
        elif role is Role.CLOSE:
            questions.pop()
        elif role is Role.COMMA:
            questions[-1] = 0
        elif token.kind not in _WORDS and token.value == "?":
            questions[-1] += 1
        elif role is Role.COLON and questions[-1]:
            questions[-1] -= 1
            role = Role.BINARY
        elif is_export and token.value == "*":
            role = Role.OPERAND
        elif role is Role.OPERAND and before is Role.SIGN and token.kind in _NUMBERS and token.start > end:
            roles[-1] = Role.LONE_SIGN
        roles.append(role)
        end = token.end
    return roles


def _role(token: Token, before: Role, names: Collection[int]) -> Role:
    """Return the role of a token that depends only on the previous one."""
    if token.kind == "NAME":
        is_keyword = token.value in _KEYWORDS and token.start not in names and before is not Role.DOT
        return Role.KEYWORD if is_keyword else Role.OPERAND
    if token.kind in _WORDS:
        return Role.OPERAND
    if token.value in {"-", "+"} and before in _BEFORE_OPERANDS:
        return Role.SIGN
    return _OF_TEXT.get(token.value, Role.BINARY)


def is_spaced(before: Role, after: Role) -> bool:
    """Return whether a blank separates two tokens."""
    if after in {Role.CLOSE, Role.COMMA, Role.COLON, Role.DOT, Role.BANG, Role.RANGE}:
        return False
    if before in {Role.OPEN, Role.DOT, Role.AT, Role.BANG, Role.SIGN, Role.RANGE}:
        return False
    return not (after is Role.OPEN and before in {Role.OPERAND, Role.CLOSE})
