"""Comparison of the types and type hashes of seoro and of a ROS 2 system, for a topic or service."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from seoro.bridges.ros2.wire import Endpoint


def check_type(name: str, type_name: str, others: Sequence[Endpoint]) -> None:
    """Check that some of the other endpoints have a type, if there are any.

    Raises:
        WrongType: All of them have other types.
    """
    types = sorted({other.type for other in others})
    if types and type_name not in types:
        raise WrongType(f"{name} is of type {' and '.join(types)}, not {type_name}")


def match_types(
    name: str, type_name: str, others: Sequence[Endpoint], types: TypeStore
) -> tuple[str | None, TypeStore]:
    """Return the type hash that matches the other endpoints, and the definitions with that hash.

    Without other endpoints, it is the hash of seoro. If the other endpoints announce no hash, return None. For
    another hash, seoro may know a matching edition of the package.

    Args:
        name: Topic or service.
        type_name: Type of the topic or service.
        others: Endpoints on the other side.
        types: Definitions that seoro knows.

    Raises:
        WrongType: The other endpoints have another type.
        DefinitionMismatch: The other endpoints have another definition of the type.
        UnknownInterface: seoro does not know the type.
    """
    try:
        return matching_hash(name, type_name, others, types.type_hash(type_name)), types
    except DefinitionMismatch:
        for theirs in _hashes(type_name, others):
            if theirs is not None and (edition := types.matching(type_name, theirs)) is not None:
                return theirs, edition
        raise


def matching_hash(name: str, type_name: str, others: Sequence[Endpoint], ours: str) -> str | None:
    """Return the hash of a definition if it matches the other endpoints; None if they announce no hash.

    Args:
        name: Topic or service.
        type_name: Type of the topic or service.
        others: Endpoints on the other side.
        ours: Hash of the definition.

    Raises:
        WrongType: The other endpoints have another type.
        DefinitionMismatch: The other endpoints have another definition of the type.
    """
    check_type(name, type_name, others)
    theirs = _hashes(type_name, others)
    if not theirs or ours in theirs:
        return ours
    if None in theirs:
        return None
    raise DefinitionMismatch(name, type_name, str(theirs[0]), ours)


def announced_hash(type_name: str, others: Sequence[Endpoint], types: TypeStore) -> str | None:
    """Return the hash that a subscription announces: that of all publishers, which may look for it, or seoro's."""
    theirs = {other.type_hash for other in others if other.type == type_name}
    if len(theirs) == 1:
        return theirs.pop()
    try:
        return types.type_hash(type_name)
    except UnknownInterface:
        return None


def _hashes(type_name: str, others: Sequence[Endpoint]) -> list[str | None]:
    """Return the hashes announced by endpoints of a type, sorted."""
    return sorted({other.type_hash for other in others if other.type == type_name}, key=str)
