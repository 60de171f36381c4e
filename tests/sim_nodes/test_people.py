"""People and carts: motions, bodies, contacts, goals, crowds."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Avoidance, Outcome, Position3D
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.agents import drawing
from sim_nodes.geometry import Pose2
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import PYBULLET_IN_MORE

on_both = pytest.mark.parametrize("engine", PYBULLET_IN_MORE)

WORLD = """
name: square
extent: [-5, -5, 5, 5]
walls:
  - points: [[-4.9, -4.9], [4.9, -4.9], [4.9, 4.9], [-4.9, 4.9], [-4.9, -4.9]]
robots:
  - {name: turtlebot4, robot: turtlebot4}
poses:
  - {name: exit, pose: {x: 3.0, y: 3.0}}
"""


@pytest.fixture
def world(tmp_path: Path) -> Path:
    return tmp_path / "square.yaml"


def open_world(path: Path, more: str = "", engine: str = "mujoco", seed: int = 1) -> Client:
    path.write_text(WORLD + more)
    return Client(str(path), seed, engine)


def spawn(client: Client, name: str, x: float, y: float, avoid: Avoidance = Avoidance.NONE) -> None:
    client.ask(wire.SPAWN_PERSON, wire.SpawnPerson(name=name, pose=pose(x, y), avoid=avoid))


def walk(
    client: Client, name: str, *points: tuple[float, float], place: str = "", speed: float = 0.0, goal: str = ""
) -> None:
    path = tuple(Position3D(*point) for point in points)
    client.ask(
        wire.WALK_ALONG, wire.WalkAlong(id=goal or name, person=name, points=path, place=place, speed=speed)
    )


def place(client: Client, name: str) -> tuple[float, float]:
    x, y, _ = client.simulator.simulation.engine.body_state(name).position
    return x, y


def advance(client: Client, until: float) -> list[wire.Contact]:
    contacts: list[wire.Contact] = []
    while client.simulator.simulation.time < until - 1e-9:
        contacts += client.advance(until).contacts
    return contacts


@on_both
def test_people_walk_along_the_path_of_their_world(engine: str, world: Path) -> None:
    client = open_world(
        world,
        """
people:
  - {name: visitor, pose: {x: -2, y: 2}, speed: 1.0, avoid: none, walk: {points: [[0, 2], [0, 4]]}}
carts:
  - {name: cart, size: [0.8, 0.5, 1.0], pose: {x: -2, y: -2}, path: {points: [[-1, -2], [-2, -2]], repeat: true}}
""",
        engine,
    )
    advance(client, 1.5)
    assert place(client, "visitor") == pytest.approx((-0.6, 2.0), abs=0.1)
    advance(client, 6.0)
    state = client.simulator.simulation.engine.body_state("visitor")
    assert state.position == pytest.approx((0.0, 4.0, 0.01), abs=0.06)
    assert state.planar.yaw == pytest.approx(math.pi / 2, abs=0.1)
    assert place(client, "cart")[0] < -1.0
    assert place(client, "cart")[1] == pytest.approx(-2.0, abs=0.05)
    infos = [client.ask(wire.GET_ENTITY_INFO, wire.EntityName(name=name)).category for name in ("visitor", "cart")]
    assert infos == [wire.Category.HUMAN, wire.Category.DYNAMIC_OBJECT]


@on_both
def test_a_goal_of_a_spawned_person_ends_at_a_named_pose(engine: str, world: Path) -> None:
    client = open_world(world, engine=engine)
    spawn(client, "guest", 3.0, 0.0)
    walk(client, "guest", (2.0, 1.0), place="exit", speed=2.0)
    with pytest.raises(RequestRefused, match="guest is busy with goal 'guest'"):
        walk(client, "guest", (0.0, 0.0), goal="second")
    ended, _ = client.run_until("guest")
    assert ended.outcome is Outcome.SUCCEEDED
    assert ended.time == pytest.approx(2.4, abs=0.4)
    assert place(client, "guest") == pytest.approx((3.0, 3.0), abs=0.06)


def test_goals_without_an_end_are_cancelled(world: Path) -> None:
    client = open_world(world)
    spawn(client, "guest", 3.0, 0.0)
    spawn(client, "child", -3.0, 0.0)
    area = (Position3D(-4.0, -4.0), Position3D(4.0, 4.0))
    client.ask(wire.WANDER, wire.Wander(id="wander", person="guest", lower=area[0], upper=area[1]))
    client.ask(wire.WALK_AFTER, wire.WalkAfter(id="follow", person="child", entity="guest", distance=0.8))
    advance(client, 15.0)
    distance = math.dist(place(client, "guest"), place(client, "child"))
    assert distance < 2.5
    client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="wander"))
    client.ask(wire.STAND_STILL, wire.PersonName(person="child"))
    ended = client.advance(15.1).occurrences
    assert [(each.id, each.outcome) for each in ended] == [
        ("wander", Outcome.CANCELED),
        ("follow", Outcome.CANCELED),
    ]
    before = place(client, "child")
    client.advance(16.0)
    assert math.dist(place(client, "child"), before) < 0.3


@pytest.mark.more
def test_a_blocked_goal_is_aborted(world: Path) -> None:
    client = open_world(world)
    spawn(client, "guest", -1.0, 0.0)
    walk(client, "guest", (2.0, 0.0))
    ended, contacts = client.run_until("guest")
    assert ended.outcome is Outcome.ABORTED
    assert "guest is blocked at (" in ended.message
    assert contacts[0].strikers == ("guest",)
    assert math.dist(place(client, ROBOT), (0.0, 0.0)) < 0.4


def test_the_goal_of_a_deleted_person_is_aborted(world: Path) -> None:
    client = open_world(world)
    spawn(client, "guest", 3.0, 0.0)
    walk(client, "guest", (3.0, 3.0))
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="guest"))
    [ended] = client.advance(0.1).occurrences
    assert (ended.id, ended.outcome, ended.message) == ("guest", Outcome.ABORTED, "guest was deleted")


@on_both
def test_a_robot_that_drives_into_a_person_strikes_it_and_stays_outside(engine: str, world: Path) -> None:
    client = open_world(world, engine=engine)
    spawn(client, "guest", 0.6, 0.1)
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.0, duration=4.0))
    contacts = advance(client, 4.5)
    assert [(each.first, each.second, each.strikers) for each in contacts[:1]] == [("guest", ROBOT, (ROBOT,))]
    assert place(client, "guest") == pytest.approx((0.6, 0.1), abs=0.05)
    assert place(client, ROBOT)[0] < 0.4


def test_a_lidar_sees_legs(world: Path) -> None:
    client = open_world(world)
    spawn(client, "guest", 1.5, 0.1)
    simulation = client.simulator.simulation
    lidar = simulation.pipeline(ROBOT, "lidar")
    lidar.in_use = True
    client.advance(0.3)
    assert lidar.latest is not None
    assert 1.3 < float(lidar.latest.data.ranges.min()) < 1.6


@pytest.mark.parametrize("avoid", [Avoidance.SOCIAL_FORCE, Avoidance.ORCA])
@on_both
def test_people_avoid_each_other_and_robots(engine: str, avoid: Avoidance, world: Path) -> None:
    client = open_world(world, engine=engine)
    for index, (x, y) in enumerate([(-4.0, 2.0), (4.0, 2.02), (-4.0, 0.1), (4.0, -0.05)]):
        spawn(client, f"p{index}", x, y, avoid)
        walk(client, f"p{index}", (-x, y))
    contacts = advance(client, 12.0)
    assert contacts == []
    ends = [place(client, f"p{index}")[0] for index in range(4)]
    assert ends == pytest.approx([4.0, -4.0, 4.0, -4.0], abs=0.1)


CROWD = "crowds:\n  - {name: crowd, count: 12, area: [-4, 1, 4, 4], speed: [0.8, 1.4], wander: [-4, -4, 4, 4]}\n"


def test_a_crowd_is_drawn_by_the_seed(world: Path) -> None:
    def traits(seed: int) -> list[tuple[str, Pose2, float]]:
        agents = open_world(world, CROWD, seed=seed).simulator.simulation.entities.agents
        return [(name, agent.pose, agent.speed) for name, agent in agents.items()]

    first = traits(1)
    assert first == traits(1) != traits(2)
    assert len(first) == 12
    speeds = [speed for _, _, speed in first]
    assert 0.8 <= min(speeds) < max(speeds) <= 1.4
    places = [at for _, at, _ in first]
    assert all(-4 < at.x < 4 and 1 < at.y < 4 for at in places)
    assert min(a.distance(b.x, b.y) for a in places for b in places if a is not b) > 0.5


@on_both
def test_a_crowd_repeats_to_the_bit(engine: str, world: Path) -> None:
    ends = []
    for _ in range(2):
        client = open_world(world, CROWD, engine)
        advance(client, 3.0)
        ends.append([client.simulator.simulation.engine.body_state(f"crowd_{i}") for i in range(1, 13)])
    assert ends[0] == ends[1]


def test_reset_returns_people_to_their_start(world: Path) -> None:
    client = open_world(world, CROWD)
    start = place(client, "crowd_1")
    advance(client, 3.0)
    assert math.dist(place(client, "crowd_1"), start) > 0.5
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    assert place(client, "crowd_1") == pytest.approx(start, abs=1e-6)
    advance(client, 6.0)
    assert math.dist(place(client, "crowd_1"), start) > 0.5


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("people:\n  - {name: a, speed: [2, 1]}\n", "invalid range of `speed`; expected the lower value first"),
        ("people:\n  - {name: a, speed: 9}\n", "speed"),
        ("people:\n  - {name: turtlebot4}\n", "duplicate name 'turtlebot4' of a person"),
        ("people:\n  - {name: a, pose: {x: 9}}\n", r"square: 'a': \(9, 0\) is outside of the world"),
        ("people:\n  - {name: a, pose: {x: 0.2}}\n", "the person or cart 'a' at .* overlaps turtlebot4"),
        (
            "people:\n  - {name: a, pose: {x: 2}, walk: {points: [[4.8, 0]]}}\n",
            r"the way from \(2, 0\) to \(4.8, 0\) is 0.2. m from a wall at .*; expected 0.25 m or more: add",
        ),
        ("people:\n  - {name: a, wander: [1, 1, 0, 2]}\n", "invalid `wander`; expected "),
        ("people:\n  - {name: a, wander: [0, 0, 1, 1], walk: {points: [[1, 1]]}}\n", "either `walk` or `wander`"),
        ("crowds:\n  - {name: a, count: 101, area: [0, 0, 1, 1]}\n", "count"),
        (
            "crowds:\n  - {name: a, count: 50, area: [2, 2, 3, 3]}\n",
            "found no free place for 'a_.*' in the `area`",
        ),
        (
            "crowds:\n" + "".join(f"  - {{name: {name}, count: 60, area: [2, 2, 3, 3]}}\n" for name in "ab"),
            "found 120 people and carts; expected at most 100",
        ),
    ],
)
def test_invalid_people_are_refused(more: str, words: str, world: Path) -> None:
    with pytest.raises(RequestRefused, match=words):
        open_world(world, more)


def test_invalid_requests_are_refused(world: Path) -> None:
    client = open_world(world)
    spawn(client, "guest", 3.0, 0.0)
    after = wire.WalkAfter(id="f", person="guest", entity="ghost", distance=1.0)
    cases: list[tuple[str, Callable[[], object]]] = [
        ("unknown person 'ghost'; people and carts: guest", lambda: walk(client, "ghost", (0.0, 0.0))),
        ("unknown named pose 'attic'; named poses: exit", lambda: walk(client, "guest", place="attic")),
        ("found 0 points of a path; expected 1 to 100", lambda: walk(client, "guest")),
        ("speed of 9 m/s; expected 0.05 to 5 m/s", lambda: walk(client, "guest", (0.0, 2.0), speed=9.0)),
        (r"\(7, 0\) is outside of the world", lambda: walk(client, "guest", (7.0, 0.0))),
        ("duplicate name 'guest'", lambda: spawn(client, "guest", 0.0, 3.0)),
        ("would overlap guest", lambda: spawn(client, "other", 3.1, 0.0)),
        ("unknown entity 'ghost' to follow", lambda: client.ask(wire.WALK_AFTER, after)),
    ]
    for words, request in cases:
        with pytest.raises(RequestRefused, match=words):
            request()


def test_orca_without_its_library_is_refused(world: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "find_spec", lambda name: None)
    with pytest.raises(RequestRefused, match=r"the package pyrvo is missing, .* `pip install 'seoro\[people\]'`"):
        open_world(world, "people:\n  - {name: a, avoid: orca, pose: {x: 2}}\n")


def test_a_person_with_the_name_of_a_generated_thing_is_refused(world: Path) -> None:
    world.write_text("name: generated\ngenerate: {obstacles: {}}\npeople: [{name: obstacles}]\n")
    with pytest.raises(
        RequestRefused, match="the name 'obstacles' of a person is in use by another thing of the world; rename"
    ):
        Client(str(world))
