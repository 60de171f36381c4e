"""Telling a lab what to do by hand: leases, stops, and the emergency stop.

An emergency stop goes two ways at once: published on one key, which reaches whoever is connected, also in the
middle of something long, and as a request to each node and executor that is alive, which acknowledges it. Each
endpoint is told as soon as it is connected to, whatever becomes of the others.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from seoro.bridges import wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.session import AsyncSession, SessionError, is_secured, publishing
from seoro.bridges.sim.requests import ask
from seoro.errors import BackendError, BackendLost, BackendRefused, InvalidUse
from seoro.keys.roles import MOVING
from seoro.lab.seeing import Member, Reached, asking, connected, look, members_at, nobody, reaching

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

CONNECTIONS = 3  # to an endpoint, by which an emergency stop is tried
STAGGER = 0.1  # [s] between their beginnings
STOP_WITHIN = 2.0  # [s] that a node may take to acknowledge that all stands still
GIVE_BACK_WITHIN = 5.0  # [s] that it may take to end a lease that is not had in full
Place = tuple[str, str | None]
"""A robot or a lease, and the endpoint of its node, if that is known."""


@dataclass(frozen=True)
class Outcome:
    """What came of asking somebody.

    Attributes:
        endpoint: Where it was looked for.
        called: Who was asked.
        done: What they have done, in words.
        error: Why they have not; empty if they have.
        took: From the beginning of the emergency stop to the answer [s]; infinite if it does not matter.
        is_somebody: Whether there is somebody at all.
        stopped: Robots or runs that were stopped in an emergency.
        is_elsewhere: Whether a node has none of the named robots.
    """

    endpoint: str
    called: str
    done: str = ""
    error: str = ""
    took: float = math.inf
    is_somebody: bool = True
    stopped: tuple[str, ...] = ()
    is_elsewhere: bool = False


async def stop_all(endpoints: Sequence[str], by: str, reason: str, keys: Path | None = None) -> list[Outcome]:
    """Emergency stop: nothing moves from now on until it is released.

    Args:
        endpoints: Where nodes, executors or routers are.
        by: Who stops it, and `reason` why, for others.
        keys: Folder of keys, as in `reaching`.
    """
    asked = wire.EmergencyStop(by=by, reason=reason)
    return await _stop_at_all(dict.fromkeys(endpoints, asked), keys)


async def stop_named(
    places: Sequence[Place], endpoints: Sequence[str], by: str, reason: str, keys: Path | None = None
) -> list[Outcome]:
    """Emergency stop of some robots: they do not move until it is released, and the others of their nodes go on.

    Nobody is asked first which node has a robot: each node at its endpoint is told, and those that have it obey.

    Args:
        places: The robots.
        endpoints: Where nodes are looked for.
        by: Who stops them, and `reason` why, for others.
        keys: Folder of keys, as in `reaching`.
    """
    asked: dict[str, wire.EmergencyStop] = {}
    for endpoint in endpoints:
        robots = tuple(dict.fromkeys(name for name, at in places if at in (None, endpoint)))
        if robots:
            asked[endpoint] = wire.EmergencyStop(by=by, reason=reason, robots=robots)
    outcomes = await _stop_at_all(asked, keys)
    missing = [place for place in places if not any(_has_stopped(each, place) for each in outcomes)]
    told = [each for each in outcomes if not each.is_elsewhere]
    if not missing:
        return told
    states = [member.state for member in await look(endpoints, keys)]
    known = sorted({robot.name for state in states if state is not None for robot in state.robots})
    why = f"no node that was reached has this robot (robots there: {', '.join(known) or 'none'})"
    is_somebody = any(each.is_somebody for each in outcomes)
    return [*told, *(Outcome("", name, error=why, is_somebody=is_somebody) for name, _ in missing)]


def _has_stopped(outcome: Outcome, place: Place) -> bool:
    name, endpoint = place
    return name in outcome.stopped and endpoint in (None, outcome.endpoint)


async def _stop_at_all(asked: Mapping[str, wire.EmergencyStop], keys: Path | None) -> list[Outcome]:
    """Stop what lives at endpoints, all at once: who is reached waits for nobody who is not."""
    began = time.monotonic()
    found: dict[str, list[Outcome]] = {endpoint: [] for endpoint in asked}

    async def stop(endpoint: str) -> None:
        found[endpoint] = await _stop_soon(endpoint, asked[endpoint], keys, began)
        if _is_wrong(found[endpoint]):
            # A connection may not come about on a machine that is busy, and goals may end a little later.
            found[endpoint] = await _stop_at(endpoint, asked[endpoint], keys, began)

    async with anyio.create_task_group() as tasks:
        for endpoint in found:
            tasks.start_soon(stop, endpoint)
    return [each for outcomes in found.values() for each in outcomes]


def _is_wrong(outcomes: Sequence[Outcome]) -> bool:
    return any(each.error and not each.is_elsewhere for each in outcomes)


async def _stop_soon(endpoint: str, asked: wire.EmergencyStop, folder: Path | None, began: float) -> list[Outcome]:
    """Stop what lives at an endpoint by the first of several connections, each a moment after the one before.

    One in some dozen takes a second while an endpoint is flooded. Who is stopped twice stays stopped.

    Returns:
        What came of the first that has done it, else of the last.
    """
    found: list[Outcome] = []

    async def attempt(after: float, over: anyio.CancelScope) -> None:
        nonlocal found
        await anyio.sleep(after)
        outcomes = await _stop_at(endpoint, asked, folder, began)
        if not found or _is_wrong(found):
            found = outcomes
        if not _is_wrong(outcomes):
            over.cancel()

    async with anyio.create_task_group() as tasks:
        for number in range(CONNECTIONS):
            tasks.start_soon(attempt, number * STAGGER, tasks.cancel_scope)
    return found


async def _stop_at(endpoint: str, asked: wire.EmergencyStop, folder: Path | None, began: float) -> list[Outcome]:
    key, payload = wire.emergency_key(wire.NAMESPACE), wire.encode(asked)
    try:
        async with AsyncExitStack() as stack:
            session, keys = await stack.enter_async_context(connected(endpoint, folder))
            own = keys if is_secured(endpoint) else None
            if own is None or own.identity.role in MOVING:  # others are told when they ask
                publisher = await stack.enter_async_context(publishing(session, key, is_urgent=True))
                publisher.put(payload, _sealed(own, key, payload))
            members = await members_at(endpoint, session, keys)
            if asked.robots:  # which executors do not have
                members = [each for each in members if not each.member.is_executor]
            return await _ask_all(members, wire.EMERGENCY_STOP, asked, began)
    except (SessionError, InvalidUse) as error:
        return [await _ask(nobody(endpoint, str(error)), wire.EMERGENCY_STOP, asked)]


def _sealed(keys: Keys | None, key: str, payload: bytes) -> bytes | None:
    if keys is None:
        return None
    from seoro.keys.sealing import seal_urgently  # noqa: PLC0415 - only where there are keys

    return seal_urgently(keys, key, payload)


async def release_all(endpoints: Sequence[str], by: str, reason: str, keys: Path | None = None) -> list[Outcome]:
    """Let things move again."""
    async with reaching(endpoints, keys) as reached:
        asked = wire.ReleaseStop(by=by, reason=reason)
        return await _ask_all(reached, wire.RELEASE_STOP, asked, math.inf)


async def _ask_all(
    reached: Sequence[Reached], verb: wire.Verb[wire.Q, wire.A], asked: wire.Q, began: float
) -> list[Outcome]:
    outcomes: dict[int, Outcome] = {}

    async def ask_one(index: int, each: Reached) -> None:
        outcomes[index] = await _ask(each, verb, asked, began)

    async with anyio.create_task_group() as tasks:
        for index, each in enumerate(reached):
            tasks.start_soon(ask_one, index, each)
    return [outcomes[index] for index in sorted(outcomes)]


async def _ask(each: Reached, verb: wire.Verb[wire.Q, wire.A], asked: wire.Q, began: float = math.inf) -> Outcome:
    member = each.member
    if each.session is None or not member.node:
        return Outcome(member.endpoint, member.called, error=member.why, is_somebody=False)
    try:
        if member.is_executor:
            with anyio.fail_after(STOP_WITHIN):
                answer = await _executor(each, each.session).ask(verb, asked)
            came = time.monotonic()
        else:
            address = each.address(each.session)
            answer = await ask(address, verb, asked, STOP_WITHIN)
            came = time.monotonic()
    except TimeoutError:
        return Outcome(member.endpoint, member.called, error=f"no answer within {STOP_WITHIN:g} s")
    except BackendRefused as error:
        is_elsewhere = isinstance(asked, wire.EmergencyStop) and error.code == wire.Result.NOT_FOUND
        return Outcome(member.endpoint, member.called, error=str(error), is_elsewhere=is_elsewhere)
    except (BackendError, InvalidUse, SessionError) as error:
        return Outcome(member.endpoint, member.called, error=str(error))
    what = "runs" if member.is_executor else "robots"
    done = Outcome(member.endpoint, member.called, _in_words(verb.name, answer, what), took=came - began)
    if not isinstance(answer, wire.EmergencyStopped):
        return done
    if answer.unsettled:
        why = f"{done.done}; goals of {', '.join(answer.unsettled)} have not ended, and may go on"
        done = replace(done, done="", error=why)
    return replace(done, stopped=answer.stopped)


def _executor(each: Reached, session: AsyncSession) -> Executor:
    secured = is_secured(each.member.endpoint)
    return Executor(session, each.member.node, minor=0, keys=each.keys, is_secured=secured)


def _in_words(verb: str, answer: wire.Message, what: str) -> str:
    """What was done; `what` is what there may be to stop."""
    if isinstance(answer, wire.EmergencyStopped):
        return f"stopped {', '.join(answer.stopped)}" if answer.stopped else f"stopped; there are no {what}"
    return {wire.LEASE_ROBOTS.name: "leased", wire.STOP_ROBOT.name: "stopped"}.get(verb, "released")


# ---------------------------------------------------------------- robots by name


async def lease(
    places: Sequence[Place],
    endpoints: Sequence[str],
    name: str,
    purpose: str,
    duration: float,
    keys: Path | None = None,
) -> list[Outcome]:
    """Keep robots for somebody: all of them, or none. What came of it: of all, or why not.

    Args:
        places: The robots.
        endpoints: Where nodes are looked for.
        name: Id of the lease, which no other has.
        purpose: What for, for others.
        duration: For how long [s].
        keys: Folder of keys, as in `reaching`.
    """
    async with reaching(endpoints, keys) as reached:
        homes: dict[Reached, list[str]] = {}
        members = await asking(reached)
        for place in places:
            homes.setdefault(_home(place, reached, members), []).append(place[0])
        outcomes: dict[Member, Outcome] = {}
        begun: list[Member] = []
        doubtful: set[Member] = set()
        is_had = False
        try:
            for home, robots in homes.items():
                begun.append(home.member)
                asked = wire.LeaseRobots(lease=name, robots=tuple(robots), purpose=purpose, duration=duration)
                outcomes[home.member] = await _ask(home, wire.LEASE_ROBOTS, asked)
            is_had = not any(each.error for each in outcomes.values())
        finally:
            if not is_had:
                doubtful = await _give_back(begun, name, keys)
        for member in doubtful:
            why = outcomes[member].error or "it does not answer any more"
            doubt = f"{why}; if it keeps robots all the same, `seoro lab release {name}` ends that"
            outcomes[member] = replace(outcomes[member], error=doubt)
        return [each for each in outcomes.values() if is_had or each.error]


async def _give_back(members: Sequence[Member], name: str, keys: Path | None) -> set[Member]:
    """End a lease wherever it was asked for, since answers may be lost; returns who has not said that it has.

    Sessions may be broken, or are closed where the task is cancelled: there are new ones for this.
    """
    doubtful = set(members)

    async def end(home: Reached, session: AsyncSession) -> None:
        with suppress(BackendLost, InvalidUse):
            with suppress(BackendRefused):  # there is none
                await ask(home.address(session), wire.RELEASE_LEASE, wire.ReleaseLease(lease=name), STOP_WITHIN)
            doubtful.remove(home.member)

    with anyio.move_on_after(GIVE_BACK_WITHIN, shield=True):
        async with (
            reaching([each.endpoint for each in members], keys) as reached,
            anyio.create_task_group() as tasks,
        ):
            for each in reached:
                if each.member in members and each.session is not None:
                    tasks.start_soon(end, each, each.session)
    return doubtful


async def end_lease(endpoints: Sequence[str], place: Place, keys: Path | None = None) -> Outcome:
    """End a lease by its id, or those of a robot.

    Raises:
        InvalidUse: There is none.
    """
    name, _ = place
    async with reaching(endpoints, keys) as reached:
        members = await asking(reached)
        for each, member in zip(reached, members, strict=True):
            for robot in () if member.state is None else member.state.robots:
                if robot.lease is not None and name in (robot.name, robot.lease.lease):
                    asked = wire.ReleaseLease(lease=robot.lease.lease)
                    for other in reached:  # a lease may be of robots of several nodes
                        if other.session is not None and not other.member.is_executor and other is not each:
                            await _ask(other, wire.RELEASE_LEASE, asked)
                    return await _ask(each, wire.RELEASE_LEASE, asked)
    raise InvalidUse(f"nothing is leased by the name '{name}'", help="`seoro lab status` shows what is")


async def release_named(
    places: Sequence[Place], endpoints: Sequence[str], by: str, reason: str, keys: Path | None = None
) -> list[Outcome]:
    """Let some robots move again after an emergency stop of these.

    Raises:
        InvalidUse: One of them is unknown or was not stopped by its name; nothing is released then.
    """
    async with reaching(endpoints, keys) as reached:
        members = dict(zip(reached, await asking(reached), strict=True))
        homes: dict[Reached, list[str]] = {}
        for place in places:
            home = _home(place, reached, list(members.values()))
            _check_stopped(members[home], place[0])
            homes.setdefault(home, []).append(place[0])
        return [
            await _ask(home, wire.RELEASE_STOP, wire.ReleaseStop(by=by, reason=reason, robots=tuple(robots)))
            for home, robots in homes.items()
        ]


def _check_stopped(home: Member, name: str) -> None:
    """Check that an emergency stop of a robot can be released.

    Raises:
        InvalidUse: There is none, or one of the whole node.
    """
    state = home.state
    if state is not None and state.stopped is not None:
        raise InvalidUse(f"all of {home.called} is stopped", help="`seoro lab release --all` releases that")
    robots = () if state is None else state.robots
    stopped = sorted(robot.name for robot in robots if robot.stopped is not None)
    if name not in stopped:
        raise InvalidUse(
            f"no emergency stop holds '{name}'", help=f"stopped there: {', '.join(stopped) or 'nothing'}"
        )


async def stop_robots(
    places: Sequence[Place], endpoints: Sequence[str], keys: Path | None = None
) -> list[Outcome]:
    """Stop robots, which may go on afterwards."""
    async with reaching(endpoints, keys) as reached:
        members = await asking(reached)
        homes = [(_home(place, reached, members), place[0]) for place in places]
        return [await _ask(home, wire.STOP_ROBOT, wire.StopRobot(robot=robot)) for home, robot in homes]


def _home(place: Place, reached: Sequence[Reached], members: Sequence[Member]) -> Reached:
    """Where a robot lives.

    Raises:
        InvalidUse: Nowhere, or it is not clear which of several is meant.
    """
    name, endpoint = place
    found: list[Reached] = []
    known: list[str] = []
    for each, member in zip(reached, members, strict=True):
        names = [] if member.state is None else [robot.name for robot in member.state.robots]
        known += names
        if name in names and endpoint in (None, member.endpoint):
            found.append(each)
    if len(found) == 1:
        return found[0]
    if found:
        where = ", ".join(each.member.called for each in found)
        raise InvalidUse(f"several robots are called '{name}': at {where}", help="name it as the lab file does")
    raise InvalidUse(f"there is no robot '{name}'", help=f"robots: {', '.join(sorted(known)) or 'none'}")
