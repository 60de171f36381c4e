"""Numbers of the members of enumerations, including extensions (7.3.3)."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang import ast
from seoro.lang.check.lookup import Lookup
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names
from seoro.lang.namespaces import Space
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.symbols import EnumSymbol

_Member = tuple[EnumSymbol, str]
_Value = int | tuple[ast.EnumValueReference, Space]  # the scope of the reference


class Enumerations:
    """Numbers the members of all enumerations.

    Args:
        program: The program, with all declarations and extensions.
        lookup: Lookup of enumerations.
        bag: Bag for messages.
    """

    def __init__(self, program: Program, lookup: Lookup, bag: Bag) -> None:
        self._program = program
        self._lookup = lookup
        self._bag = bag
        self._values: dict[EnumSymbol, dict[str, _Value]] = {}
        self._numbers: dict[_Member, int | None] = {}

    def resolve(self) -> None:
        """Number the members, and record the enumerations by the names of their members."""
        for enum in [symbol for symbol in self._program.types.values() if isinstance(symbol, EnumSymbol)]:
            first: dict[str, Span] = {}
            for member, home in enum.declared:
                name = member.name
                if name.text in first:
                    self._bag.add(names.duplicate, name.span, "member", name.text, first[name.text])
                    continue
                first[name.text] = name.span
                enum.members[name.text] = self._number(enum, name.text) or 0
                enum.spaces[name.text] = home.namespace_of(name)
                self._program.enumerations_by_member.setdefault(name.text, []).append(enum)

    def _number(self, enum: EnumSymbol, member: str) -> int | None:
        """Return the number of a member; None if it is invalid, which has been reported."""
        path: dict[_Member, ast.EnumValueReference] = {}  # each refers to the next
        here = (enum, member)
        while here not in self._numbers:
            match self._values_of(here[0]).get(here[1]):
                case ast.EnumValueReference() as reference, Space() as space:
                    if here in path:
                        self._report_circle(path, here)
                        self._numbers[here] = None
                        break
                    path[here] = reference
                    target = self._find(space, reference, here[0])
                    if target is None:
                        self._numbers[here] = None
                        break
                    here = (target, reference.member.text)
                case int() as number:
                    self._numbers[here] = number
                case _:
                    self._numbers[here] = None
        for each in path:
            self._numbers[each] = self._numbers[here]
        return self._numbers[here]

    def _report_circle(self, path: Mapping[_Member, ast.EnumValueReference], first: _Member) -> None:
        """Report members that refer to each other, at the first one found."""
        order = list(path)
        circle = (*(member for _, member in order[order.index(first) :]), first[1])
        self._bag.add(names.cyclic_reference, path[first].span, "values of members", circle)

    def _values_of(self, enum: EnumSymbol) -> dict[str, _Value]:
        """Return the values of an enumeration's members; one without a value follows the one before it."""
        if enum not in self._values:
            found: dict[str, _Value] = {}
            following = 0
            for member, home in enum.declared:
                if isinstance(member.value, ast.EnumValueReference):
                    found.setdefault(member.name.text, (member.value, home.space))
                    continue
                number = following if member.value is None else member.value
                found.setdefault(member.name.text, number)
                following = number + 1
            self._values[enum] = found
        return self._values[enum]

    def _find(self, space: Space, reference: ast.EnumValueReference, default: EnumSymbol) -> EnumSymbol | None:
        """Find the enumeration of `[enum!]member`; report an unknown one and return None."""
        target = default
        if reference.enum is not None:
            found = self._lookup.type(space, reference.enum)
            if not isinstance(found, EnumSymbol):
                span = reference.enum.span
                if found is not None:
                    self._bag.add(names.wrong_kind, span, found.name, "not an enumeration", "an enumeration")
                else:
                    known = self._program.types_of(EnumSymbol)
                    self._bag.add(names.unknown_type, span, reference.enum.text, known, "enumeration")
                return None
            target = found
        members = self._values_of(target)
        if reference.member.text not in members:
            self._bag.add(names.unknown_member, reference.span, target.name, reference.member.text, tuple(members))
            return None
        return target
