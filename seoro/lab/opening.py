"""Start and connections of the nodes of a lab for a run, which holds its robots."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator
from seoro.bridges.robot.connecting import Claim, UnknownRobot, connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.embed.backends import OpenBackends
from seoro.errors import BackendRefused, UsageError
from seoro.lab.binding import States, bind
from seoro.lab.readiness import unmet_conditions
from seoro.lab.reading import Lab
from seoro.lab.recorded import opening_bag
from seoro.lab.resetting import ResetRun, Resets
from seoro.lab.schema import BeforeFile, LimitsFile, SimulatorFile
from seoro.lab.selectors import Selector
from seoro.lab.status import listed_robots, read_states
from seoro.lab.teardown import Teardown
from seoro.runtime.contracts.backends import Backend
from seoro.runtime.execution.assignment import Home, Placement

Node = SimulatorNode | RobotNode


@asynccontextmanager
async def open_lab(
    lab: Lab,
    options: SimulatorOptions,
    resets: Resets,
    purpose: str,
    actors: frozenset[str],
    selectors: Mapping[str, Selector],
    claim: Claim,
) -> AsyncIterator[OpenBackends]:
    """Acquire all nodes and robots of a lab that a run needs, while the block lasts.

    Args:
        lab: The lab.
        options: Options of its simulator.
        resets: Loads the reset scenarios of robots.
        purpose: Purpose of the hold, shown to other clients.
        actors: Names of the actors of the scenario.
        selectors: Selectors of actors that have one.
        claim: Claim of the robots.

    Raises:
        RobotsBusy: Another client holds a robot.
        UsageError: A robot is unknown or not ready, or a claim is refused.
        BackendError: The simulator did not start.
    """
    states = await _states(lab) if selectors else {}
    bound = bind(lab, actors, selectors, states, claim.lease, may_wait=claim.waits)
    loaded = {
        robot: resets(path, lab.position_of(robot)) for robot in bound.values() if (path := lab.reset_of(robot))
    }
    async with AsyncExitStack() as stack:
        opened: dict[str, Node] = {}
        recorded = await stack.enter_async_context(opening_bag(lab, bound))
        # All runs acquire in the same order; a simulator is started last.
        for name, bridge in sorted(lab.bridges.items(), key=lambda item: (item[1].name or "", item[1].connect)):
            served = [robot for robot in bound.values() if lab.robots[robot].where == name]
            robots = tuple(sorted({lab.remote_name(robot) for robot in served}))
            if robots:
                connecting = connect_robots(bridge.connect, purpose, bridge.name, robots, claim)
                try:
                    opened[name] = await stack.enter_async_context(connecting)
                except UnknownRobot as unknown:
                    robot = next(each for each in served if f"'{lab.remote_name(each)}'" in str(unknown))
                    raise UsageError(f"{lab.position_of(robot)}: robots.{robot}: {unknown} in {name}") from unknown
        simulator = None
        if lab.simulator is not None:
            name, file = lab.simulator
            starting = _simulator(file, options, purpose, claim)
            opened[name] = simulator = await stack.enter_async_context(starting)
        places = {robot: lab.robots[robot].where for robot in bound.values()}
        nodes = {robot: opened[where] for robot, where in places.items() if where is not None}
        placements = {
            actor: _placement(lab, robot, nodes[robot]) for actor, robot in bound.items() if robot in nodes
        }
        await _check_ready(lab, nodes)
        for node in opened.values():
            _limit_requests(lab, node, [robot for robot, its_node in nodes.items() if its_node is node])
        runs = {}
        for actor, robot in bound.items():
            after = lab.robots[robot].after
            if robot in loaded and after is not None:
                runs[robot] = ResetRun(loaded[robot], nodes[robot], placements[actor], options.seed, after.within)
        teardown = Teardown(lab, nodes, runs)
        async with teardown.after_block():
            # The simulator comes first, as the preferred backend.
            backends: tuple[Backend, ...] = tuple(sorted(opened.values(), key=lambda node: node is not simulator))
            if recorded is not None:
                backends, placements = (*backends, recorded.system), {**placements, **recorded.placements}
            if recorded is None or simulator is None:
                yield OpenBackends(simulator, simulator, backends, placements, teardown)
            else:
                time = recorded.time_beside(simulator)
                yield OpenBackends(simulator, time, backends, placements, teardown, recorded.system.settle)


def _simulator(
    file: SimulatorFile, options: SimulatorOptions, purpose: str, claim: Claim
) -> AbstractAsyncContextManager[SimulatorNode]:
    if file.connect is not None:
        return connect_simulator(file.connect, options, file.name, purpose, claim)
    assert file.simulator is not None, "the schema requires one of the two"
    return start_simulator(file.simulator, options)


async def _states(lab: Lab) -> States:
    """Return the states of the robots of a lab, by their names in the lab."""
    members = await read_states(lab.endpoints)
    # Without an endpoint, a robot is at a simulator that is started for the run.
    states: dict[str, wire.RobotState | str] = {name: wire.RobotState(name=name, kinds=()) for name in lab.robots}
    for robot in listed_robots(lab):
        states[robot.name] = f"nothing answers at {robot.endpoint}"
        for member in filter(robot.is_served_by, members):
            for state in member.robots:
                if state.name == robot.remote_name:
                    states[robot.name] = state
            if member.problem:
                states[robot.name] = member.problem
    return states


def _placement(lab: Lab, robot: str, node: Node) -> Placement:
    where, name = lab.robots[robot].where, lab.remote_name(robot)
    found = next((each for each in node.robots if each.name == name), None)
    if found is None:
        known = ", ".join(sorted(each.name for each in node.robots))
        raise UsageError(
            f"{lab.position_of(robot)}: robots.{robot}: unknown robot '{name}' in {where}",
            help=f"robots of {where}: {known}",
        )
    if isinstance(node, SimulatorNode):
        node.reserve(found)
    return Placement(Home(node, name), found.kinds, lab.position_of(robot))


async def _check_ready(lab: Lab, nodes: Mapping[str, Node]) -> None:
    """Check that robots meet their conditions before a run.

    Raises:
        UsageError: A condition is not met; lists all of one robot.
    """
    for robot, node in nodes.items():
        before = lab.robots[robot].before
        if before == BeforeFile():
            continue
        states = (await node.ask(wire.GET_LAB_STATE, wire.Empty())).robots
        found = unmet_conditions(before, next(each for each in states if each.name == lab.remote_name(robot)))
        if found:
            raise UsageError(f"{lab.position_of(robot)}: robots.{robot} is not ready: {'; '.join(found)}")


def _limit_requests(lab: Lab, node: Node, robots: Sequence[str]) -> None:
    """Reject requests of a run to a node that exceed the limits of its robots."""
    limits = {lab.remote_name(robot): (lab.robots[robot].limits, lab.position_of(robot)) for robot in robots}

    def vet(request: wire.Message) -> None:
        name = getattr(request, "robot", "")
        for robot in [name] if name else limits:
            if robot in limits:
                limit, place = limits[robot]
                if excess := _excess(robot, request, limit):
                    raise BackendRefused(f"{excess} ({place})", wire.Result.OPERATION_FAILED)

    node.vet = vet


def _excess(robot: str, request: wire.Message, limit: LimitsFile) -> str:
    """Describe how a request exceeds the limits of a robot; empty if it does not."""
    match request:
        case wire.Drive(linear=speed) | wire.CmdVel(twist=wire.Twist(linear=wire.Vector3(x=speed))):
            if limit.speed is not None and abs(speed) > limit.speed:
                return f"{speed:g} m/s exceeds the limit of the robot '{robot}' in this lab, {limit.speed:g} m/s"
        case wire.NavigateThroughPoses() if limit.area is not None:
            for position in (pose.position for pose in request.poses):
                if not limit.area.contains(position.x, position.y):
                    place = f"x {position.x:g} m, y {position.y:g} m"
                    return f"{place} is outside the area of the robot '{robot}' in this lab, {limit.area}"
    return ""
