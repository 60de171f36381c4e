"""Name lookup: identifiers with and without a prefix (7.7.4.2).

A name with a prefix is searched in that namespace, then among its re-exports. A name without a prefix is searched
in the current namespace, then among the exports of the namespaces in use; several matches there are an error. Only
declarations of the requested kind count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter
from typing import TypeVar, cast

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names
from seoro.lang.members import M, Member, MemberTable
from seoro.lang.namespaces import Space
from seoro.lang.program import Declaration, Program, TypeTable
from seoro.lang.symbols import EnumSymbol, FieldSymbol, TypeSymbol, lineage

T = TypeVar("T")


class Lookup:
    """Finds declarations by name.

    Args:
        program: The program, with all declarations.
        bag: Bag for ambiguous names.
    """

    def __init__(self, program: Program, bag: Bag) -> None:
        self._program = program
        self._bag = bag
        self._exported: dict[tuple[str, str], frozenset[str]] = {}

    def type(self, space: Space, name: ast.Name) -> Declaration | None:
        """Find a type."""
        found = self._pick(space, name, lambda namespace: self._program.types.get((namespace, name.text)))
        return cast(Declaration | None, found)

    def behavior(self, space: Space, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """Find a scenario or action of an actor and its bases, or of no actor."""
        return self._of_actor(self._program.behaviors, space, actor, name)

    def modifier(self, space: Space, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """Find a modifier."""
        return self._of_actor(self._program.modifiers, space, actor, name)

    def global_parameter(self, space: Space, name: ast.Name) -> FieldSymbol | None:
        """Find a global parameter."""
        return self._pick(space, name, lambda namespace: self._program.globals.get((namespace, name.text)))

    def member(self, space: Space, members: MemberTable[M], name: ast.Name) -> M | None:
        """Find a member of a type."""
        found = members.with_text(name.text)
        return self._pick(space, name, found.get) if found else None

    def parameter(self, space: Space, members: MemberTable[M], name: ast.Name) -> M | None:
        """Find the parameter of a named argument, which needs no prefix if the name is unique."""
        found = members.with_text(name.text)
        if name.namespace is None and len(found) == 1:
            return self._note(name, next(iter(found.values())))
        return self.member(space, members, name)

    def enumerations(self, space: Space, name: ast.Name) -> list[EnumSymbol]:
        """Return the visible enumerations with a member of this name."""
        enumerations = self._program.enumerations_by_member.get(name.text, [])
        if not enumerations:
            return []
        found: dict[EnumSymbol, None] = {}
        for tier in self._tiers(space, name):
            found |= dict.fromkeys(enum for enum in enumerations if enum.spaces[name.text] in tier)
        return list(found)

    def is_member(self, space: Space, enum: EnumSymbol, name: ast.Name) -> bool:
        """Return whether a name can denote a member of an enumeration."""
        namespace = enum.spaces.get(name.text)
        return namespace is not None and any(namespace in tier for tier in self._tiers(space, name))

    # ------------------------------------------------------------ namespaces

    def exported(self, namespace: str, text: str) -> frozenset[str]:
        """Return the namespaces of all identifiers that a namespace exports under a name."""
        known = self._exported.get((namespace, text))
        if known is None:
            known = self._exported[namespace, text] = self._find_exported(namespace, text)
        return known

    def _find_exported(self, namespace: str, text: str) -> frozenset[str]:
        found: set[str] = set()
        passed, pending = {namespace}, [namespace]
        while pending:
            current = pending.pop()
            exports = self._program.exports.get(current, {})
            sources = {item.namespace or current for item in exports.get(None, ())}
            found |= {source for source in sources if (source, text) in self._program.defined}
            for item in exports.get(text, ()):
                own = item.namespace or current
                uses = item.home.space.uses if item.namespace is None else frozenset[str]()
                if (own, text) in self._program.defined:
                    found.add(own)
                else:
                    pending += {own, *uses} - passed
                    passed |= {own, *uses}
        return frozenset(found)

    def _tiers(self, space: Space, name: ast.Name) -> Iterator[Iterable[str]]:
        """Yield the namespaces to search, in order of precedence."""
        if name.namespace is not None:
            yield (name.namespace,)
            yield self.exported(name.namespace, name.text)
            return
        yield (space.name,)
        if space.uses:
            yield {namespace for used in space.uses for namespace in self.exported(used, name.text)}

    def _pick(self, space: Space, name: ast.Name, find: Callable[[str], T | None]) -> T | None:
        for tier in self._tiers(space, name):
            found = [(namespace, thing) for namespace in tier if (thing := find(namespace)) is not None]
            if len(found) > 1:
                found.sort(key=itemgetter(0))
                self._bag.add(names.ambiguous_name, name.span, name.text, tuple(key for key, _ in found))
            if found:
                return self._note(name, found[0][1])
        return None

    def _note(self, name: ast.Name, found: T) -> T:
        """Record the meaning of a name for editors."""
        if self._program.recorder is not None:
            self._program.recorder.name(name.span, found)
        return found

    def _of_actor(
        self, table: TypeTable, space: Space, actor: TypeSymbol | None, name: ast.Name
    ) -> TypeSymbol | None:
        owners: list[TypeSymbol | None] = list(lineage(actor)) if actor is not None else [None]
        for owner in owners:
            found = self._pick(space, name, lambda namespace, of=owner: table.get((namespace, of, name.text)))  # type: ignore[misc]
            if found is not None:
                return found
        return None


def candidates(members: Iterable[Member], name: ast.Name) -> tuple[str, ...]:
    """Return suggestions for an unknown name; equal identifiers of other namespaces with their prefix."""
    return tuple(
        f"{member.namespace}::{member.text}" if member.text == name.text else member.text for member in members
    )
