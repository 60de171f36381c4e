"""Changes of the world during a run."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import World


def check_world_change(present: Simulation, world: World, needed: Mapping[str, str]) -> None:
    """Refuse a world that lacks a robot of the run.

    Args:
        present: The present simulation; the new world must have its robots in use.
        world: The new world.
        needed: Kinds of further required robots by name.

    Raises:
        RequestRefused: The world lacks a robot.
    """
    kinds = {name: present.robots[name].declaration.kinds[0] for name in present.robots_in_use} | dict(needed)
    there = {robot.name: robot.declaration.kinds for robot in world.robots}
    for name, kind in sorted(kinds.items()):
        if kind not in there.get(name, ()):
            robots = name_list(f"{robot} ({has[0]})" for robot, has in there.items())
            lacking = f"which lacks the {kind} {name!r}; robots: {robots}"
            raise RequestRefused(Result.NOT_FOUND, f"the run cannot continue in the world {world.name}, {lacking}")


def enter_world(present: Simulation, world: World) -> Simulation:
    """Return a simulation of a checked world, in its initial state, that continues the present one."""
    simulation = Simulation(present.engine, world, present.seed)
    simulation.continue_from(present)
    return simulation
