"""The members of types, parameters of events and of methods: by their names, and by what people call them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, ValuesView
from types import MappingProxyType
from typing import Any, Final, Protocol, TypeVar


class Member(Protocol):
    """Something with an identifier in a namespace, and a name that is unique among its like."""

    name: str
    text: str
    namespace: str


M = TypeVar("M", bound=Member)
_NONE: Final[Mapping[str, Any]] = MappingProxyType({})


class MemberTable(Mapping[str, M]):
    """Members by their unique names, in the order in which they were added.

    Args:
        inherited: What it begins with: it is looked at in the place of a copy until something is added.
    """

    def __init__(self, inherited: MemberTable[M] | None = None) -> None:
        self._is_own = inherited is None
        self._by_name: dict[str, M] = {} if inherited is None else inherited._by_name
        self._by_text: dict[str, dict[str, M]] = {} if inherited is None else inherited._by_text

    def add(self, member: M) -> None:
        """Add a member, in the place of the one that it overrides, which has its name."""
        if not self._is_own:
            self._by_name, self._by_text, self._is_own = dict(self._by_name), dict(self._by_text), True
        self._by_name[member.name] = member
        self._by_text[member.text] = {**self.called(member.text), member.namespace: member}

    def called(self, text: str) -> Mapping[str, M]:
        """The members with an identifier, by their namespaces."""
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
        """The members; those of the base class look up each by its name."""
        return self._by_name.values()
