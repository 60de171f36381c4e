"""The verbs of `seoro.bridges.wire`, each as a function of a simulator and a request.

A module has those of one part; `PARTS` lists them.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.physics import UnstablePhysics
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import (
    arms,
    artifacts,
    cameras,
    description,
    driving,
    entities,
    faults,
    listing,
    localisation,
    mobile,
    recording,
    sensors,
    snapshots,
    spawnables,
    streams,
    whole,
)
from sim_nodes.verbs.handling import Handler

PARTS = (
    whole,
    entities,
    mobile,
    driving,
    arms,
    cameras,
    recording,
    faults,
    localisation,
    sensors,
    snapshots,
    streams,
    listing,
    description,
    spawnables,
    artifacts,
)
VERBS: MappingProxyType[str, tuple[wire.Verb[Any, Any], Handler]] = MappingProxyType(
    {verb.name: (verb, handler) for part in PARTS for verb, handler in part.HANDLERS}
)

Permit = Callable[[str, wire.Message], wire.Message]


def _permit(_verb: str, request: wire.Message) -> wire.Message:
    """Anything."""
    return request


def handle(simulator: Simulator, verb: str, payload: bytes, permit: Permit = _permit) -> bytes:
    """Carry out a request.

    Args:
        simulator: Who carries it out.
        verb: Name of the verb.
        payload: The encoded request.
        permit: Refuses what may not be asked for, and gives the request as it is to be carried out.

    Returns:
        The encoded answer.

    Raises:
        RequestRefused: It cannot be carried out.
    """
    if verb not in VERBS:
        raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"there is no verb {verb!r}: known are {listed(VERBS)}")
    known, handler = VERBS[verb]
    try:
        request = known.read(payload)
    except wire.WireError as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
    request = permit(verb, request)
    if verb != wire.REWIND.name:
        simulator.stay()
    try:
        return wire.encode(handler(simulator, request))
    except UnstablePhysics as error:
        raise RequestRefused(wire.LabResult.FAULT, str(error)) from error
