"""The verb that tells what can be spawned."""

from __future__ import annotations

from seoro.bridges import wire
from sim_nodes.messages import bounds_of
from sim_nodes.simulator import Simulator
from sim_nodes.spawnables import find_spawnables
from sim_nodes.verbs.handling import Handling


def _get_spawnables(simulator: Simulator, request: wire.GetSpawnables) -> wire.Spawnables:
    found, message = find_spawnables(simulator.models, simulator.simulation.world, request.sources)
    return wire.Spawnables(
        spawnables=tuple(
            wire.Spawnable(
                uri=each.uri,
                description=each.description,
                bounds=bounds_of(each.bounds.lower.tolist(), each.bounds.upper.tolist()),
            )
            for each in found
        ),
        message=message,
    )


HANDLERS: tuple[Handling, ...] = ((wire.GET_SPAWNABLES, _get_spawnables),)
