"""Handlers match the declarations of their verbs."""

from __future__ import annotations

from typing import Any, get_type_hints

import pytest

from seoro.bridges import wire
from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.ros2.simulators.node import RosSimulator
from seoro.bridges.serving.node import RobotServer
from seoro.bridges.wire import Verb
from seoro.executor.handlers import RequestHandlers
from sim_nodes.leasing import Leasing
from sim_nodes.verbs import HANDLERS, PARTS

OWNERS: tuple[tuple[Any, Any], ...] = (
    (RobotServer, wire.NODE_VERBS),
    (RosSimulator, wire.NODE_VERBS),
    (Leasing, wire.NODE_VERBS),
    (RequestHandlers, EXECUTOR_VERBS),
    *((part, wire.NODE_VERBS) for part in PARTS),
)
FOUND = [
    pytest.param(verb, vars(owner)[name], id=f"{owner.__name__}.{name}")
    for owner, verbs in OWNERS
    for name, verb in verbs.items()
    if name in vars(owner)
]


@pytest.mark.parametrize(("verb", "handler"), FOUND)
def test_a_handler_has_the_types_of_its_verb(verb: Verb[Any, Any], handler: Any) -> None:
    types = get_type_hints(handler)
    assert types.pop("return") in (verb.reply, type(None) if verb.reply is wire.Empty else verb.reply)
    assert verb.request in types.values()


def test_simulators_handle_all_their_verbs() -> None:
    assert HANDLERS.keys() == {verb.name for verb in wire.VERBS}


def test_nodes_with_robots_handle_leases_and_stops() -> None:
    of_bridges = {"check_robot"}  # a handler of each robot
    shared = (
        wire.NODE_VERBS.keys() - {verb.name for verb in wire.VERBS} - {"challenge", "emergency_stop"} - of_bridges
    )
    assert shared <= vars(RobotServer).keys()
    assert shared <= vars(Leasing).keys()


def test_executors_handle_all_their_verbs() -> None:
    of_others = {"challenge", "claim", "emergency_stop", "revoke"}  # authorizer, name claim, stop thread
    assert EXECUTOR_VERBS.keys() - of_others <= vars(RequestHandlers).keys()
