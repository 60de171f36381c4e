"""Definitions of the types of a recorded bag."""

from __future__ import annotations

from seoro.bridges.ros2.interfaces import InvalidDefinition, TypeStore, UnknownInterface
from seoro.bridges.ros2.recording.metadata import BagTopic


def recorded_types(topic: BagTopic, types: TypeStore, origin: str) -> TypeStore:
    """Return definitions in which the type of a topic is that of the recorded robot.

    They are those of seoro if they have the hash in the bag, else those in the bag. A bag without both has those
    of seoro.

    Args:
        topic: The topic.
        types: Definitions of seoro.
        origin: The bag, for messages.

    Raises:
        UnknownInterface: Neither seoro nor the bag defines the type, with the hash in the bag.
        InvalidDefinition: The definition in the bag is invalid.
    """
    ours = _hash_of(topic.type, types)
    if ours and topic.type_hash and (edition := types.matching(topic.type, topic.type_hash)) is not None:
        return edition
    if topic.definition and "/msg/" in topic.type:  # bags define no services and actions
        recorded = types.add_schema(topic.type, topic.definition, origin)
        theirs = recorded.type_hash(topic.type)
        if topic.type_hash in ("", theirs):
            return types if theirs == ours else recorded
    if not ours or topic.type_hash:
        raise UnknownInterface(
            f"{origin} lacks the definition of {topic.type} that {topic.name} has, and seoro lacks it, too",
            help="record MCAP files, which contain definitions",
        )
    return types


def _hash_of(type_name: str, types: TypeStore) -> str:
    """Return the hash of a type; empty if it is unknown."""
    try:
        return types.type_hash(type_name)
    except (UnknownInterface, InvalidDefinition):
        return ""
