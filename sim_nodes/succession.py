"""Going on in another world in the middle of a run."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import World


def check_successor(present: Simulation, world: World, needed: Mapping[str, str]) -> None:
    """Refuse a world to go on in that lacks a robot.

    Args:
        present: The simulation that is to go on there; the new world has to have its robots that are in use.
        world: The world.
        needed: Others that it has to have: by name, the kind of each.

    Raises:
        RequestRefused: It lacks one.
    """
    kinds = {name: present.robots[name].declaration.kinds[0] for name in present.in_use} | dict(needed)
    there = {robot.name: robot.declaration.kinds for robot in world.robots}
    for name, kind in sorted(kinds.items()):
        if kind not in there.get(name, ()):
            robots = listed(f"{robot} ({has[0]})" for robot, has in there.items())
            lacking = f"which has no {kind} {name!r}: its robots are {robots}"
            raise RequestRefused(Result.NOT_FOUND, f"the run cannot go on in the world {world.name}, {lacking}")


def succeeded(present: Simulation, world: World) -> Simulation:
    """A simulation of a world, at its initial state, in which another goes on that was checked."""
    simulation = Simulation(present.engine, world, present.seed)
    simulation.take_over(present)
    return simulation
