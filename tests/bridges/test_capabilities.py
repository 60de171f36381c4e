"""Contracts of simulator nodes name every verb that their actions need, so that they are refused before a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import pytest

from seoro.bridges import wire
from seoro.bridges.sim.capabilities import CAPABILITIES, reason_unserved
from seoro.bridges.sim.node import SimulatorNode
from seoro.runtime.contracts.backends import Selective
from seoro.runtime.contracts.sensors import ForceSensing, Sensors, SightSensing


def test_each_watch_belongs_to_a_contract() -> None:
    watches = {verb.name for verb in wire.VERBS if verb.name.startswith("watch_")}
    named = {verb.name for verbs in CAPABILITIES.values() for verb in verbs}
    assert watches - named == set()


@dataclass
class Node:
    features: wire.SimulatorFeatures


@pytest.mark.parametrize(("contract", "verb"), [(ForceSensing, "watch_force"), (SightSensing, "watch_sight")])
def test_a_node_without_a_watch_serves_other_sensors(contract: type, verb: str) -> None:
    names = tuple(each.name for each in wire.VERBS if each.name != verb)
    features = wire.SimulatorFeatures(
        features=names, robots=(), time=0.0, step=0.01, state=wire.SimulationState.STOPPED, world="empty"
    )
    node = cast(SimulatorNode, Node(features))
    assert SimulatorNode.missing_verbs(node, Sensors) == ()
    assert SimulatorNode.missing_verbs(node, contract) == (verb,)


def test_the_reason_names_the_verbs_that_are_missing() -> None:
    assert reason_unserved(ForceSensing, ["cancel_watch", "drive"], "it") == "it does not serve `watch_force`"
    assert reason_unserved(ForceSensing, ["watch_force"], "it") == ""
    assert reason_unserved(Selective, [], "it") == ""
