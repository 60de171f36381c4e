"""Asking robots for definitions that seoro does not have.

Nodes of Jazzy and later serve `~/get_type_description` for the types that they use. What they tell is taken if its
hash is the one that they announce.
"""

from __future__ import annotations

import logging
from typing import Final

from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import Message, TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Received, Subscription
from seoro.errors import BackendError, InvalidUse

SERVICE: Final = "type_description_interfaces/srv/GetTypeDescription"
ANSWER_WITHIN: Final = 2.0  # [s] that a node may take

log = logging.getLogger(__name__)


async def told_types(node: RosNode, topic: str, type_name: str, type_hash: str) -> TypeStore | None:
    """The definitions by which a topic is published, as its publishers tell them; None if none does.

    Args:
        node: Who asks.
        topic: Full name of the topic.
        type_name: Full name of the type of its messages.
        type_hash: The hash that the definition has to have.
    """
    nodes = {
        each.node.full_name
        for each in node.graph.publishers(topic)
        if each.type_hash == type_hash and each.node is not None
    }
    for name in sorted(nodes):
        service = f"{name}/get_type_description"
        if not node.graph.servers(service):
            continue
        try:
            async with node.calling(service, SERVICE) as client:
                request = {"type_name": type_name, "type_hash": type_hash, "include_type_sources": False}
                response = await client.call(request, ANSWER_WITHIN)
            if not response.successful:
                continue
            types = node.system.types.add_told(response.type_description, f"what {name} has told")
            if types.type_hash(type_name) == type_hash:
                return types
            log.warning("%s tells another definition of %s than it announces", name, type_name)
        except (BackendError, InvalidUse) as error:
            log.warning("%s cannot tell its definition of %s: %s", name, type_name, error)
    return None


async def decoded(node: RosNode, subscription: Subscription, received: Received) -> Message:
    """What a message says; those who publish it are asked for their definition if seoro has another one, or none.

    Raises:
        InvalidPayload: It is not of this type.
        UnknownInterface, DefinitionMismatch: The definition is not known, and nobody tells it.
    """
    try:
        return subscription.decode(received)
    except (UnknownInterface, DefinitionMismatch):
        type_hash = received.type_hash
        if type_hash is None:
            raise
        types = await told_types(node, subscription.topic, subscription.type, type_hash)
        if types is None:
            raise
    subscription.learn(type_hash, types)
    return subscription.decode(received)
