"""Starting and connecting what a run needs of a lab: its simulator, and its robots, which it holds."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import Claim, NoSuchRobot, connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import InvalidUse
from seoro.lab.aftermath import Aftermath
from seoro.lab.binding import States, bind
from seoro.lab.limits import limit_requests
from seoro.lab.readiness import check_ready, needs_state
from seoro.lab.reading import Lab
from seoro.lab.resetting import Resets, Resetting
from seoro.lab.schema import LimitsFile
from seoro.lab.seeing import look
from seoro.lab.wishes import Wish
from seoro.runtime.homes import Home, Placement

Node = SimulatorNode | RobotNode


@dataclass(frozen=True)
class Wanted:
    """What a run wants of a lab.

    Args:
        seed: For everything that a simulator draws.
        models: Where models to spawn are looked up.
        resets: Loads scenarios by which robots are left in order.
        purpose: What robots are held for, for others who want them.
        actors: Names of the scenario's actors.
        wishes: What actors are to be, for whom that is said.
    """

    seed: int
    models: ModelPath
    resets: Resets
    purpose: str
    actors: frozenset[str] = frozenset()
    wishes: Mapping[str, Wish] = field(default_factory=dict)


@dataclass(frozen=True)
class OpenLab:
    """What a lab consists of while a run goes on.

    Attributes:
        simulator: The simulator, if there is one.
        bridges: The bridges, whose robots are held.
        placements: Where actors live, by their names.
        aftermath: What follows.
    """

    simulator: SimulatorNode | None
    bridges: tuple[RobotNode, ...]
    placements: Mapping[str, Placement]
    aftermath: Aftermath

    @property
    def backends(self) -> tuple[Node, ...]:
        """All of them, simulators first: they are asked for what is anybody's to do."""
        return (*(() if self.simulator is None else (self.simulator,)), *self.bridges)


@asynccontextmanager
async def open_lab(lab: Lab, wanted: Wanted, claim: Claim) -> AsyncIterator[OpenLab]:
    """Have all that a run needs of a lab for as long as the block lasts; all of it, or nothing.

    Args:
        lab: The lab.
        wanted: What the run wants.
        claim: By what it claims robots.

    Raises:
        RobotsTaken: Others have something of it.
        InvalidUse: Something is not there, or cannot be had.
        BackendError: The simulator did not start.
    """
    states = await _states(lab) if wanted.wishes else {}
    bound = bind(lab, wanted.actors, wanted.wishes, states, claim.lease, may_wait=claim.waits)
    loaded = {
        robot: wanted.resets(path, lab.place(robot)) for robot in bound.values() if (path := lab.reset_of(robot))
    }
    async with AsyncExitStack() as stack:
        nodes: dict[str, Node] = {}
        # In one order wherever they are written, simulators that have to be started last.
        for name, bridge in sorted(lab.bridges.items(), key=lambda each: (each[1].name or "", each[1].connect)):
            living = [robot for robot in bound.values() if lab.robots[robot].where == name]
            robots = tuple(sorted({lab.called(robot) for robot in living}))
            if robots:
                opened = connect_robots(bridge.connect, wanted.purpose, bridge.name, robots, claim)
                try:
                    nodes[name] = await stack.enter_async_context(opened)
                except NoSuchRobot as unknown:
                    robot = next(each for each in living if f"'{lab.called(each)}'" in str(unknown))
                    raise InvalidUse(f"{lab.place(robot)}: robots.{robot}: {unknown} in {name}") from unknown
        if lab.simulator is not None:
            name, _ = lab.simulator
            nodes[name] = await stack.enter_async_context(_simulator(lab, wanted, claim))
        placements = _placements(lab, bound, nodes)
        await _check_ready(lab, bound, nodes)
        simulator = next((node for node in nodes.values() if isinstance(node, SimulatorNode)), None)
        bridges = tuple(node for node in nodes.values() if isinstance(node, RobotNode))
        for name, node in nodes.items():
            limit_requests(node, dict(_limits(lab, bound, name)))
        resets = {}
        for actor, robot in bound.items():
            after = lab.robots[robot].after
            if robot in loaded and after is not None:
                node = nodes[lab.robots[robot].where]
                resets[robot] = Resetting(loaded[robot], node, placements[actor], wanted.seed, after.within)
        aftermath = Aftermath(lab, {robot: nodes[lab.robots[robot].where] for robot in bound.values()}, resets)
        async with aftermath.following():
            yield OpenLab(simulator, bridges, placements, aftermath)


@asynccontextmanager
async def _simulator(lab: Lab, wanted: Wanted, claim: Claim) -> AsyncIterator[SimulatorNode]:
    assert lab.simulator is not None
    _, file = lab.simulator
    world = lab.world if lab.world is None else str(wanted.models.locate(Path(lab.world)))
    options = SimulatorOptions(world, wanted.seed, wanted.models)
    if file.connect is not None:
        opened = connect_simulator(file.connect, options, file.name, wanted.purpose, claim)
    else:
        assert file.simulator is not None, "the schema asks for one or the other"
        opened = start_simulator(file.simulator, options)
    async with opened as node:
        yield node


async def _states(lab: Lab) -> States:
    """How the robots of a lab are, by their names in it."""
    found = {(each.endpoint, each.node): each for each in await look(lab.endpoints)}
    states: dict[str, wire.RobotState | str] = {}
    for name, robot in lab.robots.items():
        endpoint, node_name = lab.address(robot.where)
        if endpoint is None:
            states[name] = wire.RobotState(name=name, kinds=())  # of a simulator that is started for the run
            continue
        nodes = [each for (where, node), each in found.items() if where == endpoint and node_name in (None, node)]
        states[name] = f"nothing answers at {endpoint}"
        for node in nodes:
            known = () if node.state is None else node.state.robots
            for state in known:
                if state.name == lab.called(name):
                    states[name] = state
            if node.why:
                states[name] = node.why
    return states


def _placements(lab: Lab, bound: Mapping[str, str], nodes: Mapping[str, Node]) -> Mapping[str, Placement]:
    placements = {}
    for actor, robot in bound.items():
        where, called = lab.robots[robot].where, lab.called(robot)
        node = nodes[where]
        found = next((each for each in node.robots if each.name == called), None)
        if found is None:
            known = ", ".join(sorted(each.name for each in node.robots))
            raise InvalidUse(
                f"{lab.place(robot)}: robots.{robot}: there is no robot '{called}' in {where}",
                help=f"robots of {where}: {known}",
            )
        if isinstance(node, SimulatorNode):
            node.reserve(found)
        placements[actor] = Placement(Home(node, called), found.kinds, lab.place(robot))
    return placements


async def _check_ready(lab: Lab, bound: Mapping[str, str], nodes: Mapping[str, Node]) -> None:
    for robot in bound.values():
        if not needs_state(lab.robots[robot].before):
            continue
        states = (await nodes[lab.robots[robot].where].ask(wire.GET_LAB_STATE, wire.Empty())).robots
        check_ready(lab, robot, next(state for state in states if state.name == lab.called(robot)))


def _limits(lab: Lab, bound: Mapping[str, str], node: str) -> Iterator[tuple[str, tuple[LimitsFile, str]]]:
    for robot in bound.values():
        if lab.robots[robot].where == node:
            yield lab.called(robot), (lab.robots[robot].limits, lab.place(robot))
