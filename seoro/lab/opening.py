"""Start and connections of the nodes of a lab for a run, which holds its robots."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import Claim, UnknownRobot, connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendRefused, UsageError
from seoro.lab.binding import States, bind
from seoro.lab.readiness import check_ready, needs_state
from seoro.lab.reading import Lab
from seoro.lab.resetting import ResetRun, Resets
from seoro.lab.schema import AreaFile, LimitsFile
from seoro.lab.selectors import Selector
from seoro.lab.status import read_states
from seoro.lab.teardown import Teardown
from seoro.runtime.execution.assignment import Home, Placement

Node = SimulatorNode | RobotNode


@dataclass(frozen=True)
class LabRequest:
    """Request of a run to a lab.

    Args:
        seed: Random seed of simulators.
        models: Search path of models to spawn.
        resets: Loads the reset scenarios of robots.
        purpose: Purpose of the hold, shown to other clients.
        actors: Names of the actors of the scenario.
        selectors: Selectors of actors that have one.
    """

    seed: int
    models: ModelPath
    resets: Resets
    purpose: str
    actors: frozenset[str] = frozenset()
    selectors: Mapping[str, Selector] = field(default_factory=dict)


@dataclass(frozen=True)
class OpenLab:
    """Connections of a lab during a run.

    Attributes:
        simulator: The simulator; None without one.
        bridges: The bridges with held robots.
        placements: Robots of the actors, by the names of the actors.
        teardown: Teardown after the run.
    """

    simulator: SimulatorNode | None
    bridges: tuple[RobotNode, ...]
    placements: Mapping[str, Placement]
    teardown: Teardown

    @property
    def backends(self) -> tuple[Node, ...]:
        """All nodes; the simulator comes first, as the preferred backend."""
        return (*(() if self.simulator is None else (self.simulator,)), *self.bridges)


@asynccontextmanager
async def open_lab(lab: Lab, wanted: LabRequest, claim: Claim) -> AsyncIterator[OpenLab]:
    """Acquire all nodes and robots of a lab that a run needs, while the block lasts.

    Args:
        lab: The lab.
        wanted: Request of the run.
        claim: Claim of the robots.

    Raises:
        RobotsBusy: Another client holds a robot.
        UsageError: A robot is unknown or not ready, or a claim is refused.
        BackendError: The simulator did not start.
    """
    states = await _states(lab) if wanted.selectors else {}
    bound = bind(lab, wanted.actors, wanted.selectors, states, claim.lease, may_wait=claim.waits)
    loaded = {
        robot: wanted.resets(path, lab.position_of(robot))
        for robot in bound.values()
        if (path := lab.reset_of(robot))
    }
    async with AsyncExitStack() as stack:
        nodes: dict[str, Node] = {}
        # All runs acquire in the same order; a simulator is started last.
        for name, bridge in sorted(lab.bridges.items(), key=lambda item: (item[1].name or "", item[1].connect)):
            served = [robot for robot in bound.values() if lab.robots[robot].where == name]
            robots = tuple(sorted({lab.remote_name(robot) for robot in served}))
            if robots:
                opened = connect_robots(bridge.connect, wanted.purpose, bridge.name, robots, claim)
                try:
                    nodes[name] = await stack.enter_async_context(opened)
                except UnknownRobot as unknown:
                    robot = next(each for each in served if f"'{lab.remote_name(each)}'" in str(unknown))
                    raise UsageError(f"{lab.position_of(robot)}: robots.{robot}: {unknown} in {name}") from unknown
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
                resets[robot] = ResetRun(loaded[robot], node, placements[actor], wanted.seed, after.within)
        teardown = Teardown(lab, {robot: nodes[lab.robots[robot].where] for robot in bound.values()}, resets)
        async with teardown.after_block():
            yield OpenLab(simulator, bridges, placements, teardown)


@asynccontextmanager
async def _simulator(lab: Lab, wanted: LabRequest, claim: Claim) -> AsyncIterator[SimulatorNode]:
    assert lab.simulator is not None
    _, file = lab.simulator
    world = lab.world if lab.world is None else str(wanted.models.locate(Path(lab.world)))
    options = SimulatorOptions(world, wanted.seed, wanted.models)
    if file.connect is not None:
        opened = connect_simulator(file.connect, options, file.name, wanted.purpose, claim)
    else:
        assert file.simulator is not None, "the schema requires one of the two"
        opened = start_simulator(file.simulator, options)
    async with opened as node:
        yield node


async def _states(lab: Lab) -> States:
    """Return the states of the robots of a lab, by their names in the lab."""
    found = {(each.endpoint, each.node): each for each in await read_states(lab.endpoints)}
    states: dict[str, wire.RobotState | str] = {}
    for name, robot in lab.robots.items():
        endpoint, node_name = lab.address(robot.where)
        if endpoint is None:
            states[name] = wire.RobotState(name=name, kinds=())  # at a simulator that is started for the run
            continue
        nodes = [each for (where, node), each in found.items() if where == endpoint and node_name in (None, node)]
        states[name] = f"nothing answers at {endpoint}"
        for node in nodes:
            known = () if node.state is None else node.state.robots
            for state in known:
                if state.name == lab.remote_name(name):
                    states[name] = state
            if node.problem:
                states[name] = node.problem
    return states


def _placements(lab: Lab, bound: Mapping[str, str], nodes: Mapping[str, Node]) -> Mapping[str, Placement]:
    placements = {}
    for actor, robot in bound.items():
        where, name = lab.robots[robot].where, lab.remote_name(robot)
        node = nodes[where]
        found = next((each for each in node.robots if each.name == name), None)
        if found is None:
            known = ", ".join(sorted(each.name for each in node.robots))
            raise UsageError(
                f"{lab.position_of(robot)}: robots.{robot}: unknown robot '{name}' in {where}",
                help=f"robots of {where}: {known}",
            )
        if isinstance(node, SimulatorNode):
            node.reserve(found)
        placements[actor] = Placement(Home(node, name), found.kinds, lab.position_of(robot))
    return placements


async def _check_ready(lab: Lab, bound: Mapping[str, str], nodes: Mapping[str, Node]) -> None:
    for robot in bound.values():
        if not needs_state(lab.robots[robot].before):
            continue
        states = (await nodes[lab.robots[robot].where].ask(wire.GET_LAB_STATE, wire.Empty())).robots
        check_ready(lab, robot, next(state for state in states if state.name == lab.remote_name(robot)))


def _limits(lab: Lab, bound: Mapping[str, str], node: str) -> Iterator[tuple[str, tuple[LimitsFile, str]]]:
    for robot in bound.values():
        if lab.robots[robot].where == node:
            yield lab.remote_name(robot), (lab.robots[robot].limits, lab.position_of(robot))


def limit_requests(node: Node, limits: Mapping[str, tuple[LimitsFile, str]]) -> None:
    """Reject requests of a run to a node that exceed limits.

    Args:
        node: The node.
        limits: Limits of its robots, by their names at the node, with their positions in the lab file.
    """

    def vet(request: wire.Message) -> None:
        name = getattr(request, "robot", "")
        for robot in [name] if name else limits:
            if robot in limits:
                limit, place = limits[robot]
                _check(robot, request, limit, place)

    node.vet = vet


def _check(robot: str, request: wire.Message, limit: LimitsFile, place: str) -> None:
    match request:
        case wire.Drive():
            _check_speed(robot, request.linear, limit, place)
        case wire.CmdVel():
            _check_speed(robot, request.twist.linear.x, limit, place)
        case wire.NavigateThroughPoses() if limit.area is not None:
            for pose in request.poses:
                _check_place(robot, pose, limit.area, place)


def _check_speed(robot: str, speed: float, limit: LimitsFile, place: str) -> None:
    if limit.speed is not None and abs(speed) > limit.speed:
        raise BackendRefused(
            f"{speed:g} m/s exceeds the limit of the robot '{robot}' in this lab, {limit.speed:g} m/s ({place})",
            wire.Result.OPERATION_FAILED,
        )


def _check_place(robot: str, pose: wire.Pose3D, area: AreaFile, place: str) -> None:
    x, y = pose.position.x, pose.position.y
    if not area.contains(x, y):
        raise BackendRefused(
            f"x {x:g} m, y {y:g} m is outside the area of the robot '{robot}' in this lab, {area} ({place})",
            wire.Result.OPERATION_FAILED,
        )
