"""Tables of members and parameters, by unique name and by identifier."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, ValuesView
from types import MappingProxyType
from typing import Any, Final, Protocol, TypeVar


class Member(Protocol):
    """A declaration with an identifier in a namespace, and a name that is unique in its table."""

    name: str
    text: str
    namespace: str


M = TypeVar("M", bound=Member)
_NONE: Final[Mapping[str, Any]] = MappingProxyType({})


class MemberTable(Mapping[str, M]):
    """Members by their unique names, in the order in which they were added.

    Args:
        inherited: Initial members; copied before the first addition.
    """

    def __init__(self, inherited: MemberTable[M] | None = None) -> None:
        self._is_own = inherited is None
        self._by_name: dict[str, M] = {} if inherited is None else inherited._by_name
        self._by_text: dict[str, dict[str, M]] = {} if inherited is None else inherited._by_text

    def add(self, member: M) -> None:
        """Add a member; replace one of the same name."""
        if not self._is_own:
            self._by_name, self._by_text, self._is_own = dict(self._by_name), dict(self._by_text), True
        self._by_name[member.name] = member
        self._by_text[member.text] = {**self.with_text(member.text), member.namespace: member}

    def with_text(self, text: str) -> Mapping[str, M]:
        """Return the members with an identifier, by namespace."""
        return self._by_text.get(text, _NONE)

    def __getitem__(self, name: str) -> M:
        return self._by_name[name]

    def __contains__(self, name: object) -> bool:
        return name in self._by_name

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    def values(self) -> ValuesView[M]:
        """Return the members, faster than the base class, which looks up each name."""
        return self._by_name.values()
