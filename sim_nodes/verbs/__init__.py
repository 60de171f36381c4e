"""Handlers of the verbs of `seoro.bridges.wire`: functions of a simulator and a request, named like their verbs.

Each module of `PARTS` handles the verbs of one topic. A handler returns its reply; None stands for an empty one.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused, check_id, name_list, read_request
from sim_nodes.outcomes import feature_unsupported
from sim_nodes.physics import UnstablePhysics
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import buildings, entities, measures, people, queries, robots, sensors, simulation

PARTS = (simulation, entities, people, buildings, robots, sensors, measures, queries)

Handler = Callable[[Simulator, Any], wire.Message | None]
HANDLERS: MappingProxyType[str, Handler] = MappingProxyType(
    {verb.name: vars(part)[verb.name] for part in PARTS for verb in wire.VERBS if verb.name in vars(part)}
)

Permit = Callable[[wire.Verb[Any, Any], wire.Message], wire.Message]


def _permit(_verb: wire.Verb[Any, Any], request: wire.Message) -> wire.Message:
    """Permit every request."""
    return request


def handle(simulator: Simulator, name: str, payload: bytes, permit: Permit = _permit) -> bytes:
    """Handle a request.

    Args:
        simulator: The simulator.
        name: Name of the verb.
        payload: Encoded request.
        permit: Refuses requests without permission, and completes others.

    Returns:
        Encoded reply.

    Raises:
        RequestRefused: The request is invalid or cannot be carried out.
    """
    if name not in HANDLERS:
        raise feature_unsupported(f"unknown verb {name!r}; verbs: {name_list(HANDLERS)}")
    verb = wire.NODE_VERBS[name]
    request = permit(verb, read_request(verb, payload))
    if isinstance(request, wire.TrackedRequest):
        check_id(request.id)
    if not (verb is wire.REWIND or verb.is_read_only):  # viewers may ask while the simulator is ahead
        simulator.discard_checkpoint()
    try:
        return wire.encode(HANDLERS[name](simulator, request) or wire.Empty())
    except UnstablePhysics as error:
        raise RequestRefused(wire.LabResult.FAULT, str(error)) from error
