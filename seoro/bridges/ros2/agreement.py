"""Whether seoro and a ROS 2 system mean the same by the type of a topic or service."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from seoro.bridges.ros2.wire import Endpoint


def check_type(name: str, type_name: str, others: Sequence[Endpoint]) -> None:
    """Refuse a type that none of those has who are there.

    Raises:
        WrongType: They have others.
    """
    types = sorted({other.type for other in others})
    if types and type_name not in types:
        raise WrongType(f"{name} is of type {' and '.join(types)}, not {type_name}")


def agree(name: str, type_name: str, others: Sequence[Endpoint], types: TypeStore) -> tuple[str | None, TypeStore]:
    """The hash by which seoro meets those who are there, and the definitions that have it.

    The hash is seoro's own if nobody is there, and None if they tell of none. Where they have another one, seoro
    may have an edition of the package that agrees.

    Args:
        name: Of the topic or service.
        type_name: Of its type.
        others: Those at the other end.
        types: The definitions that seoro has.

    Raises:
        WrongType: They have another type.
        DefinitionMismatch: They have another definition of the type.
        UnknownInterface: There is no definition here.
    """
    try:
        return meeting_hash(name, type_name, others, types.type_hash(type_name)), types
    except DefinitionMismatch:
        for each in _hashes(type_name, others):
            if each is not None and (edition := types.matching(type_name, each)) is not None:
                return each, edition
        raise


def meeting_hash(name: str, type_name: str, others: Sequence[Endpoint], ours: str) -> str | None:
    """The hash by which a definition meets those who are there: its own, or None if they tell of none.

    Args:
        name: Of the topic or service.
        type_name: Of its type.
        others: Those at the other end.
        ours: The hash of the definition.

    Raises:
        WrongType: They have another type.
        DefinitionMismatch: They have another definition of the type.
    """
    check_type(name, type_name, others)
    theirs = _hashes(type_name, others)
    if not theirs or ours in theirs:
        return ours
    if None in theirs:
        return None
    raise DefinitionMismatch(name, type_name, str(theirs[0]), ours)


def announced_hash(type_name: str, others: Sequence[Endpoint], types: TypeStore) -> str | None:
    """The hash that a subscription announces: that of the publishers, who may look for it, or seoro's own."""
    theirs = {other.type_hash for other in others if other.type == type_name}
    if len(theirs) == 1:
        return theirs.pop()
    try:
        return types.type_hash(type_name)
    except UnknownInterface:
        return None


def _hashes(type_name: str, others: Sequence[Endpoint]) -> list[str | None]:
    """The hashes that those have who have a type, sorted."""
    return sorted({other.type_hash for other in others if other.type == type_name}, key=str)
