"""Starting and connecting what a lab file names."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import InvalidUse
from seoro.lab.reading import Lab
from seoro.runtime.homes import Home, Placement


@dataclass(frozen=True)
class OpenLab:
    """What a lab consists of while a run goes on.

    Attributes:
        simulator: The simulator, if there is one.
        bridges: The bridges, whose robots are held.
        placements: Where actors live, by their names.
    """

    simulator: SimulatorNode | None
    bridges: tuple[RobotNode, ...]
    placements: Mapping[str, Placement]

    @property
    def backends(self) -> tuple[SimulatorNode | RobotNode, ...]:
        """All of them, simulators first: they are asked for what is anybody's to do."""
        return (*(() if self.simulator is None else (self.simulator,)), *self.bridges)


@asynccontextmanager
async def open_lab(lab: Lab, seed: int, models: ModelPath, purpose: str) -> AsyncIterator[OpenLab]:
    """Have all that a lab names for as long as the block lasts.

    Args:
        lab: The lab.
        seed: For everything that a simulator draws.
        models: Where models to spawn are looked up.
        purpose: What robots are held for, for others who want them.

    Raises:
        InvalidUse: Something is not there, or cannot be had.
        BackendError: The simulator did not start.
    """
    async with AsyncExitStack() as stack:
        nodes: dict[str, SimulatorNode | RobotNode] = {}
        simulator: SimulatorNode | None = None
        if lab.simulator is not None:
            name, wanted = lab.simulator
            options = SimulatorOptions(lab.world, seed, models)
            if wanted.connect is not None:
                opened = connect_simulator(wanted.connect, options, wanted.name)
            else:
                assert wanted.simulator is not None, "the schema asks for one or the other"
                opened = start_simulator(wanted.simulator, options)
            nodes[name] = simulator = await stack.enter_async_context(opened)
        bridges = []
        for name, bridge in lab.bridges.items():
            robots = await stack.enter_async_context(connect_robots(bridge.connect, purpose, bridge.name))
            nodes[name] = robots
            bridges.append(robots)
        yield OpenLab(simulator, tuple(bridges), _placements(lab, nodes))


def _placements(lab: Lab, nodes: Mapping[str, SimulatorNode | RobotNode]) -> Mapping[str, Placement]:
    placements = {}
    for actor, robot in lab.robots.items():
        node = nodes[robot.where]
        found = next((each for each in node.robots if each.name == robot.called), None)
        if found is None:
            known = ", ".join(sorted(each.name for each in node.robots))
            raise InvalidUse(
                f"{lab.place(actor)}: robots.{actor}: there is no robot '{robot.called}' in {robot.where}",
                help=f"robots of {robot.where}: {known}",
            )
        if isinstance(node, SimulatorNode):
            node.reserve(found)
        placements[actor] = Placement(Home(node, robot.called), found.kinds, lab.place(actor))
    return placements
