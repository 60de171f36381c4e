"""Recoveries of a blocked robot, without physics: it is held in place."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from seoro.bridges.wire import Outcome
from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.contracts import ControlInput, Path, PlanRequest
from sim_nodes.navigation.decisions import decide
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.maps import build_map
from sim_nodes.navigation.navigator import Navigator, Phase
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.retries import Retries
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.sensors.lidar import Scan

INTERVAL = 0.02  # [s]
ANGLES = np.linspace(-math.pi, math.pi, 360, endpoint=False)
NOTHING = Scan(np.full(360, np.inf), ANGLES, Pose2(0.0, 0.0, 0.0), np.full(360, np.inf), np.full(360, np.inf))
HERE = ControlInput(Pose2(-1.0, 0.0, 0.0), AT_REST, NOTHING, np.zeros((0, 2)), touched=False, tick=0)


@pytest.fixture
def navigator() -> Navigator:
    """Return the navigator of a robot on the wrong side of a wall."""
    known = build_map((-3.0, -3.0, 3.0, 3.0), (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5),))
    navigator = Navigator(known, ObstacleLayer(known), BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    return navigator


def moved(
    navigator: Navigator, limit: float = 60.0, now: ControlInput = HERE
) -> tuple[list[Velocity], Outcome | None]:
    """Return the velocities until the goal ends, tick by tick."""
    velocities = []
    for tick in range(round(limit / INTERVAL)):
        ended = decide([(navigator, replace(now, tick=tick))])[0] if tick % navigator.period == 0 else None
        velocities.append(navigator.velocity())
        if ended is not None:
            return velocities, ended.outcome
    return velocities, None


def test_recoveries_are_back_up_spin_and_wait_in_turn(navigator: Navigator) -> None:
    velocities, outcome = moved(navigator)
    assert outcome is Outcome.ABORTED
    assert navigator.recoveries == 6
    back = sum(-velocity.linear for velocity in velocities if velocity.linear < 0.0) * INTERVAL
    assert back == pytest.approx(2 * 0.15, rel=0.1)
    turned = sum(velocity.angular for velocity in velocities) * INTERVAL
    assert turned == pytest.approx(2 * math.pi / 2, rel=0.1)
    kinds = [(velocity.linear < 0.0, velocity.angular > 0.0) for velocity in velocities]
    changes = [kind for kind, before in zip(kinds, [None, *kinds], strict=False) if kind != before and any(kind)]
    assert changes == [(True, False), (False, True)] * 2
    assert len(velocities) * INTERVAL == pytest.approx(7 * 0.6 + 2 * (1.5 + 1.6 + 5.0), abs=0.8)


def test_a_robot_too_close_to_a_rear_obstacle_leaves_forwards() -> None:
    known = build_map(
        (-3.0, -3.0, 3.0, 3.0),
        (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5), Wall("behind", -1.2, 0.0, math.pi / 2, 1.0, 0.1, 0.5)),
    )
    navigator = Navigator(known, ObstacleLayer(known), BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    velocities, _ = moved(navigator, 2.0)
    ahead = sum(velocity.linear for velocity in velocities) * INTERVAL
    assert ahead == pytest.approx(0.14, rel=0.1)
    assert min(velocity.linear for velocity in velocities) == 0.0


def test_a_robot_with_no_room_behind_stands_still_instead_of_backing_up() -> None:
    known = build_map(
        (-3.0, -3.0, 3.0, 3.0),
        (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5), Wall("behind", -1.25, 0.0, math.pi / 2, 1.0, 0.1, 0.5)),
    )
    navigator = Navigator(known, ObstacleLayer(known), BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    velocities, _ = moved(navigator, 2.0)
    assert all(velocity == AT_REST for velocity in velocities)


def test_a_robot_that_touches_something_backs_up_at_once() -> None:
    known = build_map((-3.0, -3.0, 3.0, 3.0), ())
    navigator = Navigator(known, ObstacleLayer(known), BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    driving, _ = moved(navigator, 0.5)
    assert driving[-1].linear > 0.2
    touching, _ = moved(navigator, 1.0, replace(HERE, touched=True))
    assert max(velocity.linear for velocity in touching) < 0.0
    assert min(velocity.linear for velocity in touching) == pytest.approx(-0.1)


def test_without_recoveries_a_blocked_goal_is_aborted_at_once() -> None:
    known = build_map((-3.0, -3.0, 3.0, 3.0), (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5),))
    never = BASE.navigation.model_copy(update={"number_of_retries": 0})
    declaration = BASE.model_copy(update={"navigation": never})
    navigator = Navigator(known, ObstacleLayer(known), declaration, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    velocities, outcome = moved(navigator)
    assert outcome is Outcome.ABORTED
    assert navigator.recoveries == 0 and len(velocities) * INTERVAL < 1.0


def test_a_robot_that_goes_to_and_fro_between_blocked_passages_aborts(navigator: Navigator) -> None:
    """It moves on after each recovery, and then recovers where it did before."""
    passages = (HERE.pose, Pose2(-1.0, 1.0, 0.0))
    ended, tick, now = None, 0, HERE
    while ended is None and navigator.recoveries < 20:
        if navigator._phase is Phase.FOLLOW:  # a recovery has just ended, or none has begun
            now = replace(HERE, pose=passages[navigator.recoveries % 2])
        ended = decide([(navigator, replace(now, tick=tick))])[0]
        tick += navigator.period
    assert ended is not None
    assert (ended.outcome, navigator.recoveries) == (Outcome.ABORTED, 2 + 6)
    assert ended.message == "the robot found no passage on its way to (1.00, 0.00), also after 8 recoveries"


@pytest.mark.parametrize(("ahead", "plans"), [(2.0, 1), (0.9, 2)])
def test_obstacles_are_avoided_when_they_are_near(
    ahead: float, plans: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = build_map((-3.0, -3.0, 3.0, 3.0), ())
    obstacles = ObstacleLayer(known)
    navigator = Navigator(known, obstacles, BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(2.0, 0.0, 0.0),), stop_at_each=False), HERE.pose)
    made = list[PlanRequest]()
    plan = navigator._plans.planner.plan

    def counted(request: PlanRequest) -> Path | None:
        made.append(request)
        return plan(request)

    monkeypatch.setattr(navigator._plans.planner, "plan", counted)
    moved(navigator, 0.5)
    place = known.grid.cell(HERE.pose.x + ahead, 0.0)
    obstacles._cells, obstacles._counts = (
        np.array([np.ravel_multi_index(place, known.distance.shape)]),
        np.array([5]),
    )
    obstacles._places = known.grid.points(np.array([place]))
    obstacles.changes += 1
    moved(navigator, 2.0)
    assert len(made) == plans


def test_recoveries_at_new_places_are_progress() -> None:
    retries = Retries(0.6)
    retries.begin(Pose2(0.0, 0.0, 0.0))
    for number in range(20):
        place = Pose2(float(number), 0.0, 0.0)
        retries.move_on(place)
        retries.add(place)
    assert retries.without_progress == 1
    retries.add(Pose2(3.0, 0.5, 0.0))
    retries.add(Pose2(7.0, 0.5, 0.0))
    assert retries.without_progress == 3
    retries.begin_leg()
    retries.move_on(Pose2(0.0, 0.0, 0.0))
    assert retries.without_progress == 0
