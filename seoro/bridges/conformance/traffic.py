"""Rules about people, robots on paths, doors and lifts."""

from __future__ import annotations

from seoro.bridges.conformance.bench import (
    Bench,
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_near,
    expect_refused,
    place,
    rule,
)
from seoro.bridges.wire import Result, SpawnResult
from seoro.robotics.people import Avoidance
from seoro.runtime.contracts.buildings import Doors, Lifts
from seoro.runtime.contracts.people import People, Point, Traits
from seoro.runtime.contracts.robots import PathRobots
from seoro.runtime.contracts.worlds import Frames

GUEST = "guest"
TRAITS = Traits(1.0, 0.25, 1.7, Avoidance.NONE)
ARRIVED = 0.1  # [m]


async def _position(bench: Bench, entity: str) -> tuple[float, float]:
    found = await bench.cast(Frames).relative_pose(entity, "map", 0.0)
    return found.position.x, found.position.y


@rule(People, Frames)
async def people_walk_to_their_last_point(bench: Bench) -> None:
    """A spawned person stands; it walks along points with a given speed, and ends at the last one."""
    people, reports = bench.cast(People), Reports()
    await people.spawn_person(GUEST, place(2.0, 1.0), TRAITS)
    await bench.pass_time(0.5)
    x, y = await _position(bench, GUEST)
    expect_near("the position of a spawned person: x [m]", x, 2.0, 0.02)
    expect_near("the position of a spawned person: y [m]", y, 1.0, 0.02)
    start = bench.time
    path = (Point(2.0, 2.0), Point(1.0, 2.0))
    await people.walk_along(GUEST, path, "", 0.5, reports, repeat=False)
    await bench.expect_end("a walk of 2 m", reports, 15.0)
    x, y = await _position(bench, GUEST)
    expect_near("the end of a walk: x [m]", x, 1.0, ARRIVED)
    expect_near("the end of a walk: y [m]", y, 2.0, ARRIVED)
    expect_near("the duration of a walk of 2 m at 0.5 m/s [s]", bench.time - start, 4.0, 1.0)


@rule(People, Frames)
async def people_stop_when_their_goal_is_cancelled(bench: Bench) -> None:
    """A person refuses a second goal while one is active, and stands after it is cancelled."""
    people, reports = bench.cast(People), Reports()
    await people.spawn_person(GUEST, place(2.0, 1.0), TRAITS)
    goal = await people.wander(GUEST, Point(1.0, 0.5), Point(3.0, 3.0), 0.5, reports)
    second = people.walk_along(GUEST, (Point(2.0, 2.0),), "", 0.0, Reports(), repeat=False)
    await expect_refused("a second goal of a person", second, Result.INCORRECT_STATE)
    await bench.pass_time(1.0)
    await people.cancel_goal(goal)
    await bench.pass_time(0.5)
    expect_cancelled("a cancelled wandering", reports)
    before = await _position(bench, GUEST)
    await bench.pass_time(1.0)
    moved = distance(before, await _position(bench, GUEST))
    expect_near("the motion of a person without a goal [m]", moved, 0.0, 0.05)


@rule(People)
async def unknown_people_are_refused(bench: Bench) -> None:
    """Motions of unknown people, and people with the name of another entity, are refused."""
    people = bench.cast(People)
    await expect_refused(
        "a walk of an unknown person",
        people.walk_along("nobody", (Point(1.0, 1.0),), "", 0.0, Reports(), repeat=False),
        Result.NOT_FOUND,
    )
    twice = people.spawn_person(bench.robot, place(2.0, 1.0), TRAITS)
    await expect_refused("a person with the name of the robot", twice, SpawnResult.NAME_NOT_UNIQUE)


@rule(PathRobots, Frames)
async def robots_follow_paths_by_their_true_pose(bench: Bench) -> None:
    """A robot drives along a path without a localisation, ends at its last point, and stands."""
    robots, reports = bench.cast(PathRobots), Reports()
    path = (Point(0.8, 0.0), Point(1.2, 0.6))
    await robots.follow_path(bench.robot, path, 0.2, reports, repeat=False)
    await bench.expect_end("a path of 1.5 m", reports, 60.0)
    x, y, _ = await bench.truth()
    expect(distance((x, y), (1.2, 0.6)) < ARRIVED, f"a robot ends at ({x:.3f}, {y:.3f}) instead of (1.2, 0.6)")
    await bench.pass_time(0.5)
    await bench.expect_still("a robot at the end of its path")


@rule(PathRobots, Frames)
async def repeated_paths_end_by_cancellation(bench: Bench) -> None:
    """A repeated path has no end, and the robot stands after it is cancelled."""
    robots, reports = bench.cast(PathRobots), Reports()
    path = (Point(0.8, 0.0), Point(0.0, 0.0))
    goal = await robots.follow_path(bench.robot, path, 0.2, reports, repeat=True)
    await bench.pass_time(14.0)
    expect(not reports.any(), f"a repeated path was reported as {', '.join(reports.statuses)}")
    await robots.cancel_goal(goal)
    await bench.pass_time(0.5)
    expect_cancelled("a cancelled path", reports)
    await bench.expect_still("a robot whose path was cancelled")


@rule(Doors)
async def unknown_doors_are_refused(bench: Bench) -> None:
    """Requests for unknown doors are refused."""
    doors = bench.cast(Doors)
    motion = doors.move_door("nothing", 1.0, Reports())
    await expect_refused("the opening of an unknown door", motion, Result.NOT_FOUND)
    await expect_refused("the lock of an unknown door", doors.lock_door("nothing", locked=True), Result.NOT_FOUND)
    watch = doors.watch_door("nothing", 0.0, 1.0, Reports())
    await expect_refused("a watch of an unknown door", watch, Result.NOT_FOUND)


@rule(Lifts)
async def unknown_lifts_are_refused(bench: Bench) -> None:
    """Requests for unknown lifts are refused."""
    lifts = bench.cast(Lifts)
    for what, request in (("motion", lifts.move_lift), ("watch", lifts.watch_lift)):
        await expect_refused(f"a {what} of an unknown lift", request("nothing", 0, Reports()), Result.NOT_FOUND)
