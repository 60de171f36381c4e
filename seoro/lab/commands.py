"""Manual commands to a lab: leases, stops and the emergency stop.

Each endpoint is served as soon as it is connected, independently of the others.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import anyio

from seoro.bridges import wire
from seoro.bridges.session import AsyncSession
from seoro.bridges.sim.requests import ask
from seoro.concurrency.gathering import gather
from seoro.errors import BackendLost, BackendRefused, UsageError
from seoro.lab.outcomes import STOP_TIMEOUT, OnOutcome, Outcome, ignore_outcome, request_outcome
from seoro.lab.status import Connection, Member, connect_members, read_states, refresh
from seoro.lab.stopping import stop_endpoint

RELEASE_TIMEOUT = 5.0  # [s] time limit to release an incomplete lease
Place = tuple[str, str | None]
"""Name of a robot or a lease, and the endpoint of its node, if known."""
_Nodes = Mapping[Connection, tuple[Member, tuple[str, ...]]]


@dataclass(frozen=True)
class LabCommands:
    """Commands to the nodes, executors and routers at some endpoints.

    Args:
        endpoints: The endpoints.
        keys: Folder of keys, as in `connect_members`.
    """

    endpoints: Sequence[str]
    keys: Path | None = None

    async def emergency_stop_all(
        self, by: str, reason: str, on_outcome: OnOutcome = ignore_outcome
    ) -> list[Outcome]:
        """Stop all robots and runs until the stop is released.

        Args:
            by: Person who stops; `reason` is shown to others.
            on_outcome: Called with each outcome as it arrives. Stops are repeated, so a node may have several; one
                without an error is final.
        """
        request = wire.EmergencyStop(by=by, reason=reason)
        return await self._stop_everywhere(dict.fromkeys(self.endpoints, request), on_outcome)

    async def emergency_stop_robots(self, places: Sequence[Place], by: str, reason: str) -> list[Outcome]:
        """Stop some robots until the stop is released; other robots of their nodes continue.

        The stop goes to all endpoints, without a search for the robots first.

        Args:
            places: The robots.
            by: Person who stops; `reason` is shown to others.
        """
        requests: dict[str, wire.EmergencyStop] = {}
        for endpoint in self.endpoints:
            robots = tuple(dict.fromkeys(name for name, at in places if at in (None, endpoint)))
            if robots:
                requests[endpoint] = wire.EmergencyStop(by=by, reason=reason, robots=robots)
        outcomes = await self._stop_everywhere(requests)
        missing = [place for place in places if not any(_is_stopped(each, place) for each in outcomes)]
        found = [each for each in outcomes if not each.is_elsewhere]
        if not missing:
            return found
        members = await read_states(self.endpoints, self.keys)
        known = sorted({robot.name for member in members for robot in member.robots})
        error = f"unknown robot (robots of the reached nodes: {', '.join(known) or 'none'})"
        is_reached = any(each.is_reached for each in outcomes)
        return [*found, *(Outcome("", name, error=error, is_reached=is_reached) for name, _ in missing)]

    async def _stop_everywhere(
        self, requests: Mapping[str, wire.EmergencyStop], on_outcome: OnOutcome = ignore_outcome
    ) -> list[Outcome]:
        """Send stops to endpoints concurrently, so that none waits for an unreachable one."""
        began = time.monotonic()

        async def stop(endpoint: str) -> list[Outcome]:
            return await stop_endpoint(endpoint, requests[endpoint], self.keys, began, on_outcome)

        return list(chain.from_iterable(await gather(stop, requests)))

    async def release_all(self, by: str, reason: str) -> list[Outcome]:
        """Release all emergency stops at some endpoints."""
        request = wire.ReleaseStop(by=by, reason=reason)
        async with connect_members(self.endpoints, self.keys) as reached:
            return await gather(lambda each: request_outcome(each, wire.RELEASE_STOP, request), reached)

    async def lease(self, places: Sequence[Place], name: str, purpose: str, duration: float) -> list[Outcome]:
        """Lease robots to a person: all of them, or none.

        Args:
            places: The robots.
            name: Unique id of the lease.
            purpose: Purpose, shown to others.
            duration: Duration [s].

        Returns:
            Outcomes of all nodes, or the failures if there are some.
        """
        async with self._connect_nodes(places) as nodes:
            outcomes: dict[Member, Outcome] = {}
            begun: list[Member] = []
            unconfirmed: set[Member] = set()
            is_complete = False
            try:
                for node, (_, robots) in nodes.items():
                    begun.append(node.member)
                    request = wire.LeaseRobots(lease=name, robots=robots, purpose=purpose, duration=duration)
                    outcomes[node.member] = await request_outcome(node, wire.LEASE_ROBOTS, request)
                is_complete = not any(each.error for each in outcomes.values())
            finally:
                if not is_complete:
                    unconfirmed = await self._release_everywhere(begun, name)
            for member in unconfirmed:
                error = outcomes[member].error or "it no longer answers"
                doubt = f"{error}; if it still holds robots, release them by `seoro lab release {name}`"
                outcomes[member] = replace(outcomes[member], error=doubt)
            return [each for each in outcomes.values() if is_complete or each.error]

    async def _release_everywhere(self, members: Sequence[Member], name: str) -> set[Member]:
        """Release a lease at all nodes that may have granted it; returns the nodes that did not confirm.

        New sessions are opened, since the others may be broken or closed.
        """
        unconfirmed = set(members)

        async def release(node: Connection, session: AsyncSession) -> None:
            with suppress(BackendLost, UsageError):
                with suppress(BackendRefused):  # the lease is missing
                    request = wire.ReleaseLease(lease=name)
                    await ask(node.address(session), wire.RELEASE_LEASE, request, STOP_TIMEOUT)
                unconfirmed.remove(node.member)

        with anyio.move_on_after(RELEASE_TIMEOUT, shield=True):
            async with (
                connect_members([each.endpoint for each in members], self.keys) as reached,
                anyio.create_task_group() as tasks,
            ):
                for each in reached:
                    if each.member in members and each.session is not None:
                        tasks.start_soon(release, each, each.session)
        return unconfirmed

    async def release_lease(self, place: Place) -> Outcome:
        """Release a lease by its id or by a leased robot.

        Raises:
            UsageError: The lease is unknown.
        """
        name, _ = place
        async with connect_members(self.endpoints, self.keys) as reached:
            for each, member in (await refresh(reached)).items():
                for robot in member.robots:
                    if robot.lease is not None and name in (robot.name, robot.lease.lease):
                        request = wire.ReleaseLease(lease=robot.lease.lease)
                        for other in reached:  # a lease may include robots of several nodes
                            if other.session is not None and not other.member.is_executor and other is not each:
                                await request_outcome(other, wire.RELEASE_LEASE, request)
                        return await request_outcome(each, wire.RELEASE_LEASE, request)
        raise UsageError(f"unknown lease or leased robot '{name}'", help="`seoro lab status` lists leases")

    async def release_robots(self, places: Sequence[Place], by: str, reason: str) -> list[Outcome]:
        """Release the emergency stops of some robots.

        Raises:
            UsageError: A robot is unknown or has no stop of its own; then none is released.
        """
        async with self._connect_nodes(places) as nodes:
            for member, robots in nodes.values():
                _check_stopped(member, robots)
            return [
                await request_outcome(
                    node, wire.RELEASE_STOP, wire.ReleaseStop(by=by, reason=reason, robots=robots)
                )
                for node, (_, robots) in nodes.items()
            ]

    async def stop_robots(self, places: Sequence[Place]) -> list[Outcome]:
        """Stop robots once; later commands move them again."""
        async with self._connect_nodes(places) as nodes:
            return [
                await request_outcome(node, wire.STOP_ROBOT, wire.StopRobot(robot=robot))
                for node, (_, robots) in nodes.items()
                for robot in robots
            ]

    @asynccontextmanager
    async def _connect_nodes(self, places: Sequence[Place]) -> AsyncIterator[_Nodes]:
        """Connect to the nodes of robots while the block lasts; yields their states and the robots of each.

        Raises:
            UsageError: A robot is unknown, or several have its name.
        """
        async with connect_members(self.endpoints, self.keys) as reached:
            states = await refresh(reached)
            found = [(_find_node(place, states), place[0]) for place in places]
            yield {node: (states[node], tuple(name for at, name in found if at is node)) for node, _ in found}


def _is_stopped(outcome: Outcome, place: Place) -> bool:
    name, endpoint = place
    return name in outcome.stopped and endpoint in (None, outcome.endpoint)


def _check_stopped(member: Member, names: Sequence[str]) -> None:
    """Check that the emergency stops of robots of a node can be released.

    Raises:
        UsageError: A robot is not stopped, or its whole node is.
    """
    if member.state is not None and member.state.stopped is not None:
        raise UsageError(
            f"all of {member.display_name} is stopped", help="release it by `seoro lab release --all`"
        )
    stopped = sorted(robot.name for robot in member.robots if robot.stopped is not None)
    for name in names:
        if name not in stopped:
            raise UsageError(
                f"no emergency stop of '{name}'", help=f"stopped robots there: {', '.join(stopped) or 'none'}"
            )


def _find_node(place: Place, states: Mapping[Connection, Member]) -> Connection:
    """Return the connection to the node of a robot.

    Raises:
        UsageError: The robot is unknown, or several have its name.
    """
    name, endpoint = place
    found: list[Connection] = []
    known: list[str] = []
    for each, member in states.items():
        names = [robot.name for robot in member.robots]
        known += names
        if name in names and endpoint in (None, member.endpoint):
            found.append(each)
    if len(found) == 1:
        return found[0]
    if found:
        where = ", ".join(each.member.display_name for each in found)
        raise UsageError(f"several robots have the name '{name}': at {where}", help="use its name in the lab file")
    raise UsageError(
        f"unknown robot '{name}'",
        help=f"robots: {', '.join(sorted(known))}"
        if known
        else "name a lab file with `--lab`, or the endpoint of a node with `--connect`",
    )
