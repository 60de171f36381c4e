"""Type definitions requested from robots, for types that seoro does not know.

Nodes of Jazzy and later serve `~/get_type_description` for the types that they use. A description is accepted if
its hash equals the announced one.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import Message, TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import ReceivedPayload, Subscription
from seoro.bridges.ros2.type_matching import match_types
from seoro.bridges.ros2.wire import Endpoint
from seoro.errors import BackendError, UsageError

SERVICE: Final = "type_description_interfaces/srv/GetTypeDescription"
ANSWER_TIMEOUT: Final = 2.0  # [s]

log = logging.getLogger(__name__)


async def fetch_types(
    node: RosNode, endpoints: Iterable[Endpoint], type_name: str, type_hash: str
) -> TypeStore | None:
    """Fetch the definitions of a type from the nodes that use it; None if none answers.

    Args:
        node: Requesting node.
        endpoints: Publishers of a topic, or servers of a service.
        type_name: Full name of the type.
        type_hash: Required hash of the definition.
    """
    nodes = {each.node.full_name for each in endpoints if each.type_hash == type_hash and each.node is not None}
    for name in sorted(nodes):
        service = f"{name}/get_type_description"
        if not node.graph.servers(service):
            continue
        try:
            async with node.calling(service, SERVICE) as client:
                request = {"type_name": type_name, "type_hash": type_hash, "include_type_sources": False}
                response = await client.call(request, ANSWER_TIMEOUT)
            if not response.successful:
                continue
            types = node.system.types.add_remote(response.type_description, f"description by {name}")
            if types.type_hash(type_name) == type_hash:
                return types
            log.warning("%s sent another definition of %s than it announces", name, type_name)
        except (BackendError, UsageError) as error:
            log.warning("%s did not send its definition of %s: %s", name, type_name, error)
    return None


async def decode_message(node: RosNode, subscription: Subscription, received: ReceivedPayload) -> Message:
    """Decode a message; fetch the definition of its type from the publishers if seoro's differs or is missing.

    Raises:
        InvalidPayload: The payload is not a message of the type.
        UnknownInterface, DefinitionMismatch: The definition is unknown, and no publisher sends it.
    """
    try:
        return subscription.decode(received)
    except (UnknownInterface, DefinitionMismatch):
        type_hash = received.type_hash
        if type_hash is None:
            raise
        types = await fetch_types(node, node.graph.publishers(subscription.topic), subscription.type, type_hash)
        if types is None:
            raise
    subscription.add_types(type_hash, types)
    return subscription.decode(received)


async def node_for_service(node: RosNode, service: str, type_name: str) -> RosNode:
    """Return a node that knows the type of a service; its definition is fetched from the servers if necessary.

    Args:
        node: Calling node.
        service: Name of the service.
        type_name: Type of the service.

    Raises:
        InvalidName: The name is invalid.
        UnknownInterface: The definition is unknown, and no server sends it.
        WrongType: The service has another type.
    """
    service, types = node.resolve(service), node.system.types
    servers = node.graph.servers(service)
    try:
        type_name = types.canonical(type_name)
        match_types(service, type_name, servers, types)
    except (UnknownInterface, DefinitionMismatch) as problem:
        for type_hash in sorted({each.type_hash for each in servers if each.type_hash and each.type == type_name}):
            if (fetched := await fetch_types(node, servers, type_name, type_hash)) is not None:
                return replace(node, system=replace(node.system, types=fetched))
        if isinstance(problem, UnknownInterface):
            raise
    return node
