"""Chains of operators as terms: `a + b + c`, `a and b and c` and the like, which may be long."""

from __future__ import annotations

from typing import cast

from seoro.lang.plan import Arithmetic, Compare, Concatenate, Logic
from seoro.lang.solve import terms
from seoro.runtime.choose.forms import NUMBERS, NotSymbolic, Symbolic, as_term, compare

Operation = Arithmetic | Concatenate | Compare | Logic


def joined(operation: Operation) -> object:
    """Return a key that is equal for adjacent operators translated together: `and`, `or`, `+` of strings."""
    match operation:
        case Logic("and" | "or" as operator):
            return operator
        case Concatenate():
            return Concatenate
        case _:
            return id(operation)


def operated(operation: Operation, left: Symbolic, right: Symbolic) -> terms.Term:
    """Return the term of an operation with an unknown operand.

    Raises:
        NotSymbolic: It has no term.
    """
    match operation:
        case Arithmetic(operator, number=number):
            kind = cast(terms.Operation, operator)
            return terms.Arithmetic(kind, as_term(left), as_term(right), NUMBERS[number])
        case Compare(operator):
            return compare(operator, left, right)
        case _:
            raise NotSymbolic


def junction(operator: str, members: list[Symbolic]) -> Symbolic:
    """Return the term of `and` or `or`; all members but the last are unknown."""
    if len(members) == 1:
        return members[0]
    if not members:
        return operator == "and"
    whole = tuple(as_term(member) for member in members)
    return terms.Or(whole) if operator == "or" else terms.And(whole)
