"""The numbers of the members of enumerations, those of extensions included (7.3.3)."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.check.lookup import Lookup
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names
from seoro.lang.source import Span
from seoro.lang.symbols import EnumSymbol, Program, Space

_Path = tuple[tuple[EnumSymbol, str], ...]
_Value = int | tuple[ast.EnumValueReference, Space]  # where the reference stands in


class Enumerations:
    """Numbers the members of all enumerations.

    Args:
        program: The program, with all declarations and extensions.
        lookup: For the enumerations that members refer to.
        bag: Where messages go.
    """

    def __init__(self, program: Program, lookup: Lookup, bag: Bag) -> None:
        self._program = program
        self._lookup = lookup
        self._bag = bag
        self._values: dict[EnumSymbol, dict[str, _Value]] = {}

    def resolve(self) -> None:
        """Number them, and note which enumerations have a member of a name."""
        for enum in [symbol for symbol in self._program.types.values() if isinstance(symbol, EnumSymbol)]:
            first: dict[str, Span] = {}
            for member, home in enum.declared:
                name = member.name
                if name.text in first:
                    self._bag.add(names.Duplicate(name.span, "member", name.text, first[name.text]))
                    continue
                first[name.text] = name.span
                enum.members[name.text] = self._number(enum, name.text, ()) or 0
                enum.spaces[name.text] = home.namespace_of(name)
                self._program.holders.setdefault(name.text, []).append(enum)

    def _number(self, enum: EnumSymbol, wanted: str, path: _Path) -> int | None:
        """The number of a member; None if it cannot be told, which has been reported."""
        match self._values_of(enum).get(wanted):
            case ast.EnumValueReference() as reference, Space() as space:
                return self._referenced(enum, wanted, space, reference, path)
            case int() as number:
                return number
            case _:
                return None

    def _values_of(self, enum: EnumSymbol) -> dict[str, _Value]:
        """What the members of an enumeration stand for; a member without a value follows the one before it."""
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

    def _referenced(
        self, enum: EnumSymbol, member: str, space: Space, reference: ast.EnumValueReference, path: _Path
    ) -> int | None:
        here = (enum, member)
        if here in path:
            if path[0] == here:
                cycle = (*(name for _, name in path), member)
                self._bag.add(names.CyclicReference(reference.span, "values of members", cycle))
            return None
        target = self._find(space, reference, enum)
        return None if target is None else self._number(target, reference.member.text, (*path, here))

    def _find(self, space: Space, reference: ast.EnumValueReference, default: EnumSymbol) -> EnumSymbol | None:
        """The enumeration that `[enum!]member` refers to; None if there is none, which is reported."""
        target = default
        if reference.enum is not None:
            found = self._lookup.type(space, reference.enum)
            if not isinstance(found, EnumSymbol):
                known = tuple(s.name for s in self._program.types.values() if isinstance(s, EnumSymbol))
                self._bag.add(
                    names.UnknownType(reference.enum.span, reference.enum.text, known, "enumeration")
                    if found is None
                    else names.WrongKind(reference.enum.span, found.name, "no enumeration", "an enumeration")
                )
                return None
            target = found
        members = self._values_of(target)
        if reference.member.text not in members:
            self._bag.add(names.UnknownMember(reference.span, target.name, reference.member.text, tuple(members)))
            return None
        return target
