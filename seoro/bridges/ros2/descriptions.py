"""Asking robots for definitions that seoro does not have.

Nodes of Jazzy and later serve `~/get_type_description` for the types that they use. What they tell is taken if its
hash is the one that they announce.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from seoro.bridges.ros2.agreement import agree
from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import Message, TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Received, Subscription
from seoro.bridges.ros2.wire import Endpoint
from seoro.errors import BackendError, InvalidUse

SERVICE: Final = "type_description_interfaces/srv/GetTypeDescription"
ANSWER_WITHIN: Final = 2.0  # [s] that a node may take

log = logging.getLogger(__name__)


async def told_types(
    node: RosNode, endpoints: Iterable[Endpoint], type_name: str, type_hash: str
) -> TypeStore | None:
    """The definitions of a type, as those tell them who use it; None if none does.

    Args:
        node: Who asks.
        endpoints: Publishers of a topic, or servers of a service.
        type_name: Full name of the type.
        type_hash: The hash that the definition has to have.
    """
    nodes = {each.node.full_name for each in endpoints if each.type_hash == type_hash and each.node is not None}
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
        types = await told_types(node, node.graph.publishers(subscription.topic), subscription.type, type_hash)
        if types is None:
            raise
    subscription.learn(type_hash, types)
    return subscription.decode(received)


async def knowing_service(node: RosNode, service: str, type_name: str) -> RosNode:
    """The node with the definition of a service; servers are asked for it if seoro has another one, or none.

    Args:
        node: Who calls the service.
        service: Its name.
        type_name: Its type.

    Raises:
        InvalidName: There is no such name.
        UnknownInterface: The definition is not known, and nobody tells it at this time.
        WrongType: The service has another type.
    """
    service, types = node.resolve(service), node.system.types
    servers = node.graph.servers(service)
    try:
        type_name = types.canonical(type_name)
        agree(service, type_name, servers, types)
    except (UnknownInterface, DefinitionMismatch) as problem:
        for type_hash in sorted({each.type_hash for each in servers if each.type_hash and each.type == type_name}):
            if (told := await told_types(node, servers, type_name, type_hash)) is not None:
                return replace(node, system=replace(node.system, types=told))
        if isinstance(problem, UnknownInterface):
            raise
    return node
