"""Quality of navigation in situations that are hard for it, over seeds and engines.

    python benchmarks/navigation_quality.py [SITUATION ...] [--results FILE] [--seeds N] [--first N]
        [--engines ENGINE ...] [--table]

Each run is in this process, without Zenoh. Runs are appended to the results, a file of JSON lines, and not
repeated. So an interrupted benchmark continues when it is called again. After a change of the code, name a new
file. `--table` prints the table of the results without runs. It has, over all seeds and engines of a situation:

- a column for each engine: runs that end as expected;
- contact: runs in which the robot touches something;
- nearest: least distance of the robot's outline to anything;
- path: longest path, relative to the shortest one that keeps the planner's clearance (`shortest_paths.py`);
- error: largest true distance to the goal at the end;
- time, recoveries: the most of a run.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from itertools import product
from pathlib import Path

from navigation_worlds import ROBOT, obstacle_field, room_with, room_with_platform
from results import read_results, write_result
from shortest_paths import shortest_length

from seoro.bridges.wire import Contact, Occurrence, Outcome
from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.models import parse_bodies
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.physics import BodyState, Wall
from sim_nodes.simulation import Simulation
from sim_nodes.spawning import SpawnRequest
from sim_nodes.worlds.loader import World, load_world

LATEST = 120.0  # [s]
START = Pose2(0.0, 0.0, 0.0)
GOAL = Pose2(3.0, -3.0, 0.0)
HALF = 0.15  # [m] of the box
TOUCHES_BOX = 0.164 + HALF  # [m] ahead of the robot's origin where a box touches it

Spawn = Callable[[Simulation], Pose2]


@dataclass(frozen=True)
class Box:
    """A box that appears when the robot is near a point, or at once.

    Args:
        place: Returns its pose.
        near: Point [m]; None to spawn it before the start.
        within: Distance of the robot to that point [m].
    """

    place: Spawn
    near: tuple[float, float] | None = (1.5, -1.5)
    within: float = 0.4


@dataclass(frozen=True)
class Situation:
    """A drive with boxes in the way.

    Args:
        boxes: Boxes that are on no map.
        succeeds: Whether the goal can be reached.
        goal: Goal in `map`; the pose `goal` of the world without one.
        world: Returns the world of a seed; the maze by default.
        may_touch: Whether a contact cannot be avoided.
        detour: Whether the shortest path is meaningless, because the box appears late.
    """

    boxes: tuple[Box, ...] = ()
    succeeds: bool = True
    goal: Pose2 | None = GOAL
    world: Callable[[int], World] = lambda _: load_world("maze")
    may_touch: bool = False
    detour: bool = False


def at(x: float, y: float, yaw: float = 0.0) -> Spawn:
    """Return a fixed pose."""
    return lambda _: Pose2(x, y, yaw)


def ahead(gap: float) -> Spawn:
    """Return the pose of a box in front of the robot, with a gap between them [m]."""

    def place(simulation: Simulation) -> Pose2:
        robot = simulation.frames.true_pose(ROBOT)
        return robot.compose(Pose2(TOUCHES_BOX + gap, 0.0, 0.0))

    return place


def doorway(width: float) -> tuple[Box, ...]:
    """Return boxes that leave a gap of a width across the corridor at x = 1.5 [m]."""
    return tuple(Box(at(1.5 + sign * (width / 2 + HALF), 0.0), near=None) for sign in (-1.0, 1.0))


SITUATIONS = {
    "no box": Situation(),
    "box": Situation((Box(at(2.0, -2.0)),)),
    "box, turned": Situation((Box(at(2.0, -2.0, 0.4)),)),
    "box, nearer": Situation((Box(at(1.8, -1.8, math.pi / 4)),)),
    "box 9 cm ahead": Situation((Box(ahead(0.09), (1.5, -1.5), 0.6),), detour=True),
    "box 14 cm ahead": Situation((Box(ahead(0.14), (1.5, -1.5), 0.6),), detour=True),
    "box 6 mm ahead": Situation((Box(ahead(0.006), (1.5, -1.5), 0.6),), may_touch=True, detour=True),
    "box before start": Situation((Box(ahead(0.14), None),)),
    "gap of 0.47 m": Situation(doorway(0.47)),
    "box near goal": Situation((Box(at(3.0 - 0.35, -3.0 + 0.35, math.pi / 4)),)),
    "box on goal": Situation((Box(at(3.0, -3.0)),), succeeds=False),
    "blocked": Situation(
        tuple(Box(at(x, -1.2), (1.5, 0.0), 0.5) for x in (1.2, 1.5, 1.8)), succeeds=False, detour=True
    ),
    "far corner": Situation(goal=Pose2(4.5, 4.5, 1.57)),
    "car, behind": Situation(goal=Pose2(-2.2, 0.5, 0.5), world=lambda _: room_with("racecar")),
    "car, beside": Situation(goal=Pose2(-1.0, 0.5, 0.0), world=lambda _: room_with("racecar")),
    "car, turned": Situation(goal=Pose2(-1.0, 0.0, math.pi), world=lambda _: room_with("racecar")),
    "car, through a door": Situation(goal=Pose2(2.5, -1.5, 1.57), world=lambda _: room_with("racecar")),
    "car, box in the way": Situation(
        (Box(at(0.1, -0.1), (-1.0, 0.0), 0.5),),
        goal=Pose2(2.5, -1.5, 1.57),
        world=lambda _: room_with("racecar"),
        detour=True,
    ),
    "car, closed in": Situation(
        tuple(Box(at(1.0, y), (-1.0, 0.0), 0.5) for y in (-0.3, 0.0, 0.3)),
        goal=Pose2(2.5, -1.5, 1.57),
        world=lambda _: room_with("racecar"),
        succeeds=False,
        detour=True,
    ),
    "platform, box in the way": Situation(
        (Box(at(0.1, -0.1), (-1.0, 0.0), 0.3),),
        goal=Pose2(2.5, -1.5, 1.57),
        world=lambda _: room_with_platform(),
        detour=True,
    ),
    "platform, beside": Situation(goal=Pose2(-1.0, -1.2, 0.0), world=lambda _: room_with_platform()),
    "platform, through a door": Situation(goal=Pose2(2.5, -1.5, 1.57), world=lambda _: room_with_platform()),
    "field": Situation(goal=None, world=obstacle_field),
    "slalom": Situation(
        tuple(Box(at(0.2 * (-1) ** n, -0.9 - 0.62 * n), None) for n in range(3)), goal=Pose2(0.0, -3.0, -1.57)
    ),
}


@dataclass(frozen=True)
class Run:
    """Result of a run.

    Args:
        situation: Its name.
        engine: The engine.
        seed: Its seed.
        ends: Whether it ends as expected.
        contacts: Number of contacts of the robot.
        nearest: Least distance of its outline to anything [m].
        path: Length of its path, relative to the shortest one.
        error: True distance to the goal at the end [m].
        time: Simulated time [s].
        recoveries: Number of recoveries.
        message: Reason of the end.
    """

    situation: str
    engine: str
    seed: int
    ends: bool
    contacts: int
    nearest: float
    path: float
    error: float
    time: float
    recoveries: int
    message: str


def spawn_box(simulation: Simulation, place: Pose2, name: str) -> None:
    """Spawn the box of the example at a pose."""
    box = resources.files("seoro").joinpath("models/example_simulation/models/box.sdf")
    state = BodyState((place.x, place.y, 0.15), quaternion(0.0, 0.0, place.yaw))
    bodies = parse_bodies(box.read_text(encoding="utf-8"))
    simulation.entities.spawn(SpawnRequest(name, bodies, state, rename=False), simulation.time)


def drive(name: str, engine: str, seed: int) -> Run:
    """Drive once in a situation, by its name."""
    situation = SITUATIONS[name]
    world = situation.world(seed)
    simulation = Simulation(ENGINES[engine](), world, seed)
    target = situation.goal or next(each.place.planar for each in world.poses if each.name == "goal")
    base = simulation.robot(ROBOT).mobile
    start = simulation.frames.true_pose(ROBOT)
    base.set_initial_pose(start, simulation.tick)
    waiting = list(situation.boxes)
    boxes: list[Pose2] = []
    contacts, outcome, message = 0, None, "under way"
    goal = Goal("goal", (target,), stop_at_each=False)
    goes = False
    while outcome is None and simulation.time < LATEST:
        robot = simulation.frames.true_pose(ROBOT)
        for box in [each for each in waiting if each.near is None or robot.distance(*each.near) < each.within]:
            waiting.remove(box)
            place = box.place(simulation)
            spawn_box(simulation, place, f"box{len(boxes)}")
            boxes.append(place)
        if not goes:
            goes = True
            simulation.navigate(ROBOT, goal)
        simulation.run(simulation.time + 0.02)
        for event in simulation.collect():
            contacts += isinstance(event, Contact) and ROBOT in (event.first, event.second)
            if isinstance(event, Occurrence) and event.id == "goal":
                outcome, message = event.outcome, event.message
    measured = simulation.measurements().robots[ROBOT]
    truth = simulation.frames.true_pose(ROBOT)
    expected = Outcome.SUCCEEDED if situation.succeeds else Outcome.ABORTED
    shortest = math.inf
    if not situation.detour:
        shortest = shortest_length(base.declaration, map_with(simulation, boxes), start, target)
    return Run(
        name,
        engine,
        seed,
        outcome is expected,
        contacts,
        measured.closest_approach or 0.0,
        measured.path_length / shortest,
        truth.distance(target.x, target.y),
        simulation.time,
        base.recoveries,
        message,
    )


def map_with(simulation: Simulation, boxes: Sequence[Pose2]) -> NavigationMap:
    """Return the map of the world with boxes on it."""
    world = simulation.world
    sides = [Wall("box", box.x, box.y, box.yaw, 2 * HALF, 2 * HALF, 1.0) for box in boxes]
    return build_map(world.extent, [*world.walls, *sides], world.outlines)


def carry_out(names: Sequence[str], engines: Sequence[str], seeds: range, results: Path) -> None:
    """Carry out the missing runs, seed by seed, and print runs with an unexpected end or contact."""
    done = {(run.situation, run.engine, run.seed) for run in read_results(results, Run)}
    with results.open("a", encoding="utf-8") as out:
        for seed, name, engine in product(seeds, names, engines):
            if (name, engine, seed) not in done:
                run = drive(name, engine, seed)
                write_result(out, run)
                if not run.ends or (run.contacts and not SITUATIONS[name].may_touch):
                    print(run, flush=True)


def table(runs: Sequence[Run]) -> Iterator[str]:
    """Yield the lines of the table, in the order of the situations."""
    engines = sorted({run.engine for run in runs})
    head = ("situation", *engines, "contact", "nearest", "path", "error", "time", "recoveries")
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for name, situation in SITUATIONS.items():
        found = [run for run in runs if run.situation == name]
        if not found:
            continue
        figures = (
            *(ends([run for run in found if run.engine == engine]) for engine in engines),
            f"{sum(run.contacts > 0 for run in found)}",
            f"{100 * min(run.nearest for run in found):.1f} cm",
            "" if situation.detour or not situation.succeeds else f"{max(run.path for run in found):.2f}",
            f"{100 * max(run.error for run in found):.1f} cm" if situation.succeeds else "",
            f"{max(run.time for run in found):.1f} s",
            f"{max(run.recoveries for run in found)}",
        )
        yield f"| {name} | " + " | ".join(figures) + " |"


def ends(runs: Sequence[Run]) -> str:
    """Return the share of runs that end as expected."""
    return f"{sum(run.ends for run in runs)} of {len(runs)}"


def main() -> None:
    """Drive and print."""
    parser = argparse.ArgumentParser(description="Measure the quality of navigation.")
    parser.add_argument("situations", metavar="SITUATION", nargs="*", default=list(SITUATIONS))
    parser.add_argument("--results", type=Path, default=Path("navigation_quality.jsonl"), metavar="FILE")
    parser.add_argument("--seeds", type=int, default=30, metavar="N")
    parser.add_argument("--first", type=int, default=1000, metavar="N")
    parser.add_argument("--engines", nargs="+", default=[name for name in ENGINES if find_spec(name)])
    parser.add_argument("--table", action="store_true", help="print the table of the results without runs")
    options = parser.parse_args()
    if unknown := set(options.situations) - set(SITUATIONS):
        parser.error(f"unknown situation {min(unknown)!r}; expected one of {', '.join(SITUATIONS)}")
    if not options.table:
        seeds = range(options.first, options.first + options.seeds)
        carry_out(options.situations, options.engines, seeds, options.results)
    print("\n".join(table(read_results(options.results, Run))))


if __name__ == "__main__":
    main()
