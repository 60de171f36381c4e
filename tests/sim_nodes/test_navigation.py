from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.controller import LocalController
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.obstacles import HITS, ObstacleLayer
from sim_nodes.navigation.planner import Plan, plan_to
from sim_nodes.physics import Wall
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.sensors.lidar import Scan

EXTENT = (-3.0, -3.0, 3.0, 3.0)
ANGLES = np.linspace(-math.pi, math.pi, 360, endpoint=False)
HERE = Pose2(0.0, 0.0, 0.0)


def open_floor() -> NavigationMap:
    return build_map(EXTENT, ())


def room_with_wall() -> NavigationMap:
    """Return a room with a wall across the middle and a door of 1 m at its upper end."""
    return build_map(EXTENT, (Wall("w", 0.0, -0.5, math.pi / 2, 5.0, 0.1, 0.5),))


def scan_of(ranges: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Scan:
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    x = np.where(np.isfinite(ranges), finite * np.cos(ANGLES), np.inf)
    y = np.where(np.isfinite(ranges), finite * np.sin(ANGLES), np.inf)
    return Scan(ranges, ANGLES, HERE, x, y)


def thing_ahead(at: float) -> Scan:
    ranges = np.full(360, np.inf)
    ranges[np.abs(ANGLES) < 0.15] = at
    return scan_of(ranges)


NOTHING = scan_of(np.full(360, np.inf))


def test_the_plan_goes_through_the_door() -> None:
    known = room_with_wall()
    path = plan_to(known.grid, known.distance, 0.18, (1.0, -2.0)).path(-1.0, -2.0)
    assert path[0] == pytest.approx((-1.0, -2.0), abs=0.05)
    assert path[-1] == pytest.approx((1.0, -2.0), abs=0.05)
    crossing = path[np.abs(path[:, 0]).argmin()]
    assert 2.2 < crossing[1] < 2.8
    assert known.distance[known.grid.cells(*path.T)].min() > 0.3


def test_a_walled_off_goal_is_unreachable() -> None:
    known = build_map(EXTENT, (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5),))
    plan = plan_to(known.grid, known.distance, 0.18, (1.0, 0.0))
    assert plan.reaches(2.0, 2.0)
    assert not plan.reaches(-1.0, 0.0)


def test_a_robot_too_close_to_an_obstacle_can_leave() -> None:
    known = room_with_wall()
    robot = (-0.15, 0.0)  # 0.1 m from the wall
    assert not plan_to(known.grid, known.distance, 0.18, (-2.0, 0.0)).reaches(*robot)
    assert plan_to(known.grid, known.distance, 0.18, (-2.0, 0.0), robot).reaches(*robot)


def test_an_obstacle_appears_and_disappears_after_some_scans() -> None:
    known = open_floor()
    layer = ObstacleLayer(known)
    cell = known.grid.cell(1.02, 0.02)
    for _ in range(HITS - 1):
        layer.update(HERE, thing_ahead(1.02))
    assert layer.distance[cell] > 1.0
    layer.update(HERE, thing_ahead(1.02))
    assert layer.distance[cell] == 0.0
    assert layer.changes > 0
    for _ in range(10):
        layer.update(HERE, NOTHING)
    assert layer.distance[cell] > 1.0


def test_hits_on_known_walls_are_no_obstacles() -> None:
    layer = ObstacleLayer(build_map(EXTENT, (Wall("w", 1.0, 0.0, math.pi / 2, 4.0, 0.1, 0.5),)))
    before = layer.distance
    for _ in range(5):
        layer.update(HERE, thing_ahead(0.93))
    np.testing.assert_array_equal(layer.distance, before)


def follow(known: NavigationMap, plan: Plan, scan: Scan, cycles: int) -> tuple[Pose2, LocalController]:
    """Drive with ideal wheels."""
    controller = LocalController(known.grid, BASE, 0.04)
    pose = HERE
    for _ in range(cycles):
        velocity = controller.follow(plan, pose, known.distance, scan, np.inf)
        if velocity is None:
            controller.stop()
            continue
        pose = pose.compose(Pose2(velocity.linear * 0.04, 0.0, velocity.angular * 0.04))
    return pose, controller


def test_the_controller_drives_to_the_goal() -> None:
    known = open_floor()
    plan = plan_to(known.grid, known.distance, 0.18, (-1.0, 1.0))
    pose, _ = follow(known, plan, NOTHING, 250)
    assert pose.distance(-1.0, 1.0) < 0.1


def test_accelerations_and_speed_are_limited() -> None:
    known = open_floor()
    plan = plan_to(known.grid, known.distance, 0.18, (2.5, 0.0))
    controller = LocalController(known.grid, BASE, 0.04)
    speeds = []
    for _ in range(20):
        velocity = controller.follow(plan, HERE, known.distance, NOTHING, np.inf)
        assert velocity is not None
        speeds.append(velocity.linear)
    assert max(np.diff([0.0, *speeds])) <= 0.9 * 0.04 + 1e-9
    assert speeds[-1] == pytest.approx(BASE.drive.max_speed)


def test_an_obstacle_in_the_scan_only_stops_the_robot() -> None:
    known = open_floor()
    plan = plan_to(known.grid, known.distance, 0.18, (2.5, 0.0))
    controller = LocalController(known.grid, BASE, 0.04)
    velocity = controller.follow(plan, HERE, known.distance, thing_ahead(0.2), np.inf)
    assert velocity is None or velocity.linear == pytest.approx(0.0)


def test_stray_beams_do_not_stop_the_robot() -> None:
    """Every fourth beam ends before the robot, its neighbours do not."""
    known = open_floor()
    plan = plan_to(known.grid, known.distance, 0.18, (2.5, 0.0))
    ranges = np.full(360, 3.0)
    ranges[::4] = 0.25
    controller = LocalController(known.grid, BASE, 0.04)
    for _ in range(20):
        velocity = controller.follow(plan, HERE, known.distance, scan_of(ranges), np.inf)
    assert velocity is not None and velocity.linear == pytest.approx(BASE.drive.max_speed)


def test_a_thin_pole_in_the_scan_only_stops_the_robot() -> None:
    known = open_floor()
    plan = plan_to(known.grid, known.distance, 0.18, (2.5, 0.0))
    ranges = np.full(360, 3.0)
    ranges[np.abs(ANGLES) < math.atan2(0.015, 0.25)] = 0.25  # 3 cm wide
    controller = LocalController(known.grid, BASE, 0.04)
    velocity = controller.follow(plan, HERE, known.distance, scan_of(ranges), np.inf)
    assert velocity is None or velocity.linear < 0.1


def test_a_walled_in_robot_is_blocked() -> None:
    ring = [
        Wall("r", 0.32 * math.cos(a), 0.32 * math.sin(a), a + math.pi / 2, 0.2, 0.1, 0.5)
        for a in np.arange(0, 6.2, 0.4)
    ]
    known = build_map(EXTENT, ring)
    plan = plan_to(known.grid, known.distance, 0.18, (2.0, 0.0), (0.0, 0.0))
    assert LocalController(known.grid, BASE, 0.04).follow(plan, HERE, known.distance, NOTHING, np.inf) is None


def test_a_robot_beside_a_door_frame_curves_away_from_it() -> None:
    """Straight ahead, the frame is too close; at rest, the robot already looks through the door."""
    walls = [Wall("w", 0.0, sign * 1.225, math.pi / 2, 1.55, 0.1, 0.5) for sign in (-1.0, 1.0)]
    known = build_map((-4.9, -2.1, 4.1, 2.1), walls)
    beside = Pose2(-0.1148, 0.2758, -0.6586)
    plan = plan_to(known.grid, known.distance, 0.18, (2.5, 0.0), (beside.x, beside.y))
    velocity = LocalController(known.grid, BASE, 0.04).follow(plan, beside, known.distance, NOTHING, np.inf)
    assert velocity is not None
    assert velocity.linear > 0.0 and velocity.angular < 0.0


def test_the_controller_respects_the_turn_rate_limit() -> None:
    slow = BASE.model_copy(update={"drive": BASE.drive.model_copy(update={"max_turn_rate": 0.4})})
    controller = LocalController(open_floor().grid, slow, 0.04)
    for _ in range(100):
        velocity = controller.steer(Velocity(0.0, -1.2))
    assert velocity.angular == pytest.approx(-0.4)


@pytest.mark.parametrize("seed", range(5))
def test_the_map_has_the_distance_of_each_cell_to_the_nearest_wall(seed: int) -> None:
    chance = np.random.default_rng(seed)
    places = chance.uniform(-3.0, 3.0, (1 + 2 * seed, 3))
    walls = [Wall("w", float(x), float(y), float(yaw), 1.0, 0.1, 0.5) for x, y, yaw in places]
    nearest = np.min([build_map(EXTENT, [wall]).distance for wall in walls], axis=0)
    known = build_map(EXTENT, walls)
    assert np.array_equal(known.distance, nearest)
