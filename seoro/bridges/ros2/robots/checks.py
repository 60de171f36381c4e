"""Checks of a robot behind a bridge: parts that scenarios need and that are missing, silent or different."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import suppress
from typing import Final

import anyio

from seoro.bridges.ros2.clients.lifecycle import lifecycle_state
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.clock_checks import clock_problems, stamp_problems
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.needs import Need, needs_of
from seoro.bridges.ros2.robots.parts import ACTS, PUBLISHES, SUBSCRIBES, all_endpoints, is_of_bridge
from seoro.bridges.ros2.robots.profile import Profile
from seoro.bridges.ros2.router_checks import REMEDY, hidden_peers
from seoro.bridges.ros2.wire import Endpoint, Kind, Qos, RmwZenoh
from seoro.bridges.ros2.wire.qos import mismatch
from seoro.bridges.wire import RobotProblem
from seoro.errors import BackendError

MESSAGE_TIMEOUT: Final = 2.0  # [s]
STATE_TIMEOUT: Final = 2.0  # [s] for the state of a lifecycle node
MAX_LISTED: Final = 3  # names that may be meant instead
_LACKING: Final = {
    SUBSCRIBES: "no subscription to {}",
    PUBLISHES: "no publisher of {}",
    ACTS: "no server of {}",
}


async def check_robot(profile: Profile, link: RobotLink) -> tuple[RobotProblem, ...]:
    """Return the problems of a robot, after a few seconds at most.

    Args:
        profile: Profile of the robot.
        link: Link to the robot.
    """
    needs, graph = list(needs_of(profile)), link.node.graph
    nodes = sorted({each.node.full_name for need in needs for each in _found(link, need) if each.node is not None})
    later: list[RobotProblem] = []

    async def check_states() -> None:
        later.extend([problem async for problem in _state_problems(link, needs)])

    async def check_clocks() -> None:
        later.extend(await clock_problems(link.node, nodes))

    async def check_router() -> None:
        is_rmw_zenoh = isinstance(graph.dialect, RmwZenoh)
        hidden = await hidden_peers(link.node.system.session) if is_rmw_zenoh else ""
        if hidden:
            later.append(RobotProblem(text=hidden, help=REMEDY, is_fatal=False))

    async with anyio.create_task_group() as tasks:
        for check in (check_states, check_clocks, check_router):
            tasks.start_soon(check)
        await _wait_for_messages(link, needs)
    found = [problem for need in needs for problem in _need_problems(link, need, graph)]
    return (*found, *_joint_problems(profile, link), *stamp_problems(link), *later)


async def _wait_for_messages(link: RobotLink, needs: Sequence[Need]) -> None:
    """Wait until all streams have a recent message, or for a while."""
    streams = [link.node.resolve(need.name) for need in needs if need.is_stream]
    with anyio.move_on_after(MESSAGE_TIMEOUT):
        await link.intake.arrivals.wait_for(
            lambda: not any(link.is_silent(topic, MESSAGE_TIMEOUT) for topic in streams)
        )


def _found(link: RobotLink, need: Need) -> tuple[Endpoint, ...]:
    """Return the endpoints of a need, without those of seoro's bridges."""
    name, graph = link.node.resolve(need.name), link.node.graph
    match need.part.kind:
        case Kind.SUBSCRIPTION:
            found = graph.subscriptions(name)
        case Kind.PUBLISHER:
            found = graph.publishers(name)
        case _:
            found = graph.action_servers(name)
    return tuple(each for each in link.node.others(found) if not is_of_bridge(each))


def _need_problems(link: RobotLink, need: Need, graph: RosGraph) -> Iterator[RobotProblem]:
    name, found = link.node.resolve(need.name), _found(link, need)
    types = sorted({each.type for each in found})
    if not found:
        text = f"{_LACKING[need.part.kind].format(name)}: {need.owner} is not running"
        yield _problem(need, text, f"start it, or correct `{need.key}` in the profile{_instead(need, graph)}")
    elif not {*types} & {*need.part.types}:
        text = f"{name} has the type {' and '.join(types)}, expected {' or '.join(need.part.types)}"
        yield _problem(need, text, f"correct `{need.key}` in the profile{_instead(need, graph)}")
    elif need.is_stream and link.is_silent(name, MESSAGE_TIMEOUT):
        text = f"no message on {name} within {MESSAGE_TIMEOUT:g} s: {link.explain_silence(name)}"
        yield _problem(need, text, f"check {need.owner} ({_owners(found)})")
    elif need.part.kind is PUBLISHES and (error := link.error_of(name)):
        yield _problem(need, error, f"check {need.owner} ({_owners(found)})")
    yield from _qos_problems(link, need, found)


def _problem(need: Need, text: str, advice: str) -> RobotProblem:
    return RobotProblem(text=text, help=advice, is_fatal=need.is_fatal)


def _instead(need: Need, graph: RosGraph) -> str:
    """List names of the same kind and type that may be meant."""
    part = need.part
    others = {each.name for each in all_endpoints(graph) if each.kind is part.kind and each.type in part.types}
    return f"; found: {', '.join(sorted(others)[:MAX_LISTED])}" if others else ""


def _owners(found: Sequence[Endpoint]) -> str:
    return ", ".join(sorted({each.node.full_name for each in found if each.node is not None})) or "behind a bridge"


def _qos_problems(link: RobotLink, need: Need, found: Sequence[Endpoint]) -> Iterator[RobotProblem]:
    """Yield differences of QoS profiles that lose messages."""
    name = link.node.resolve(need.name)
    own = (
        link.qos_of(need.name) if need.part.kind is PUBLISHES else Qos() if need.part.kind is SUBSCRIBES else None
    )
    for each in found:
        if each.qos is None or own is None:
            continue
        text = mismatch(each.qos, own) if need.part.kind is PUBLISHES else mismatch(own, each.qos)
        if text:
            advice = f"change the QoS profile of {_owners([each])}: over DDS, they do not connect"
            yield RobotProblem(text=f"QoS of {name}: {text}", help=advice, is_fatal=False)


def _joint_problems(profile: Profile, link: RobotLink) -> Iterator[RobotProblem]:
    arm = profile.arm
    message = None if arm is None else link.latest(arm.joint_states)
    if arm is None or message is None:
        return
    gripper = () if arm.gripper is None else (arm.gripper.joint,)
    missing = [name for name in (*arm.joints, *gripper) if name not in message.name]
    if missing:
        topic = link.node.resolve(arm.joint_states)
        text = f"{topic} lacks the joints {', '.join(missing)}; it has {', '.join(message.name)}"
        yield RobotProblem(text=text, help="correct the names in the profile, or start the other controllers")


async def _state_problems(link: RobotLink, needs: Sequence[Need]) -> AsyncIterator[RobotProblem]:
    """Yield action servers whose lifecycle node is not active."""
    for need in needs:
        for server in _found(link, need) if need.part.kind is ACTS else ():
            owner = "" if server.node is None else server.node.full_name
            if not owner or not link.node.graph.servers(f"{owner}/get_state"):
                continue
            state = ""
            with anyio.move_on_after(STATE_TIMEOUT), suppress(BackendError):
                state = await lifecycle_state(link.node, owner)
            if state != "active":
                text = f"{need.owner} ({owner}) is {state or 'not answering'}, expected active"
                yield _problem(
                    need, text, "activate it; the lifecycle manager of Nav2 does that when all nodes start"
                )
