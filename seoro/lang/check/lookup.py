"""What names mean: identifiers with and without a prefix (7.7.4.2).

A name with a prefix is looked for in that namespace, then among what the namespace exports again. A name without
one is looked for in the current namespace, then among what the namespaces in use export; several there are an
error. Only declarations of the kind that is asked for count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter
from typing import TypeVar, cast

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names
from seoro.lang.members import M, Member, MemberTable
from seoro.lang.symbols import Declaration, EnumSymbol, FieldSymbol, Program, Space, TypeSymbol, TypeTable, lineage

T = TypeVar("T")


class Lookup:
    """Finds declarations by name.

    Args:
        program: The program, with all declarations.
        bag: Where ambiguous names are reported.
    """

    def __init__(self, program: Program, bag: Bag) -> None:
        self._program = program
        self._bag = bag
        self._exported: dict[tuple[str, str], frozenset[str]] = {}

    def type(self, space: Space, name: ast.Name) -> Declaration | None:
        """The type that a name means."""
        found = self._pick(space, name, lambda namespace: self._program.types.get((namespace, name.text)))
        return cast(Declaration | None, found)

    def behavior(self, space: Space, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """The scenario or action of an actor, or of none, that a name means; an actor has those of its bases."""
        return self._of_actor(self._program.behaviors, space, actor, name)

    def modifier(self, space: Space, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """The modifier that a name means."""
        return self._of_actor(self._program.modifiers, space, actor, name)

    def global_parameter(self, space: Space, name: ast.Name) -> FieldSymbol | None:
        """The global parameter that a name means."""
        return self._pick(space, name, lambda namespace: self._program.globals.get((namespace, name.text)))

    def member(self, space: Space, members: MemberTable[M], name: ast.Name) -> M | None:
        """The one of some members of a type that a name means."""
        found = members.called(name.text)
        return self._pick(space, name, found.get) if found else None

    def parameter(self, space: Space, members: MemberTable[M], name: ast.Name) -> M | None:
        """The parameter that the name of an argument means, which needs no prefix if it is the only one."""
        found = members.called(name.text)
        if name.namespace is None and len(found) == 1:
            return self._note(name, next(iter(found.values())))
        return self.member(space, members, name)

    def enumerations(self, space: Space, name: ast.Name) -> list[EnumSymbol]:
        """The enumerations with a member of this name."""
        holders = self._program.holders.get(name.text, [])
        if not holders:
            return []
        found: dict[EnumSymbol, None] = {}
        for tier in self._tiers(space, name):
            found |= dict.fromkeys(enum for enum in holders if enum.spaces[name.text] in tier)
        return list(found)

    def is_member(self, space: Space, enum: EnumSymbol, name: ast.Name) -> bool:
        """Whether a name can mean a member of an enumeration."""
        namespace = enum.spaces.get(name.text)
        return namespace is not None and any(namespace in tier for tier in self._tiers(space, name))

    # ------------------------------------------------------------ namespaces

    def exported(self, namespace: str, text: str) -> frozenset[str]:
        """The namespaces of all identifiers that a namespace exports under a name."""
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
        """The namespaces in which a name may be found; those found earlier hide those found later."""
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
                self._bag.add(names.AmbiguousName(name.span, name.text, tuple(key for key, _ in found)))
            if found:
                return self._note(name, found[0][1])
        return None

    def _note(self, name: ast.Name, found: T) -> T:
        """Tell the recorder, if there is one."""
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
    """What may have been meant by a name that was not found; one that has it needs a prefix here."""
    return tuple(
        f"{member.namespace}::{member.text}" if member.text == name.text else member.text for member in members
    )
