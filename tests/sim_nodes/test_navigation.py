from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.arcs import Points, arc_points, free_lengths
from sim_nodes.navigation.contracts import ControlInput, Path
from sim_nodes.navigation.controller import ArcController
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.obstacles import HITS, ObstacleLayer
from sim_nodes.navigation.ramp import Ramp
from sim_nodes.physics import Wall
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.sensors.lidar import Scan
from tests.sim_nodes.plans import plan_to, setup_for

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
    path = plan_to(known, (-1.0, -2.0), (1.0, -2.0))
    assert path is not None
    assert path.points[0].tolist() == [-1.0, -2.0] and path.points[-1].tolist() == [1.0, -2.0]
    crossing = path.points[np.abs(path.points[:, 0]).argmin()]
    assert 2.2 < crossing[1] < 2.8
    assert known.distance[known.grid.cells(*path.points.T)].min() > 0.25


def test_a_path_over_open_floor_is_straight() -> None:
    path = plan_to(open_floor(), (-2.0, -1.0), (2.0, 0.7))
    assert path is not None
    assert path.to_go[0] == pytest.approx(math.hypot(4.0, 1.7), rel=1e-6)
    assert np.hypot(*np.diff(path.points, axis=0).T).max() < 0.051


def test_a_path_around_a_corner_is_short_and_keeps_its_distance() -> None:
    known = build_map(EXTENT, (Wall("w", 0.0, -1.5, math.pi / 2, 3.0, 0.1, 0.5),))
    path = plan_to(known, (-1.0, -1.0), (1.0, -1.0))
    assert path is not None
    shortest = 2.0 * math.hypot(1.0, 1.18)  # over the tip of the wall at the clearance
    assert path.to_go[0] < 1.17 * shortest
    assert known.grid.interpolate(known.distance, *path.points.T).min() > 0.25


def test_a_walled_off_goal_is_unreachable() -> None:
    known = build_map(EXTENT, (Wall("w", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5),))
    assert plan_to(known, (2.0, 2.0), (1.0, 0.0)) is not None
    assert plan_to(known, (-1.0, 0.0), (1.0, 0.0)) is None


def test_a_robot_too_close_to_an_obstacle_can_leave() -> None:
    known = room_with_wall()
    robot = (-0.15, 0.0)  # 0.1 m from the wall
    path = plan_to(known, robot, (-2.0, 0.0))
    assert path is not None
    assert path.to_go[0] == pytest.approx(1.85, abs=0.05)


def test_an_obstacle_appears_and_disappears_after_some_scans() -> None:
    known = open_floor()
    layer = ObstacleLayer(known)
    cell = known.grid.cell(1.02, 0.02)
    for _ in range(HITS - 1):
        layer.update(HERE, thing_ahead(1.02))
    assert len(layer.points) == 0 and layer.distance(1.0)[cell] > 1.0
    layer.update(HERE, thing_ahead(1.02))
    assert layer.distance(1.0)[cell] < 0.04
    assert np.hypot(*layer.points.T).tolist() == pytest.approx([1.02] * len(layer.points), abs=0.01)
    assert layer.changes > 0
    for _ in range(10):
        layer.update(HERE, NOTHING)
    assert layer.distance(1.0)[cell] > 1.0


def test_hits_on_known_walls_are_no_obstacles() -> None:
    layer = ObstacleLayer(build_map(EXTENT, (Wall("w", 1.0, 0.0, math.pi / 2, 4.0, 0.1, 0.5),)))
    before = layer.distance(1.0)
    for _ in range(5):
        layer.update(HERE, thing_ahead(0.93))
    np.testing.assert_array_equal(layer.distance(1.0), before)


def test_obstacles_where_beams_have_no_return_are_remembered() -> None:
    layer = ObstacleLayer(open_floor())
    for _ in range(HITS):
        layer.update(HERE, thing_ahead(1.02))
    assert len(layer.hidden_points(HERE, thing_ahead(1.02))) == 0
    assert len(layer.hidden_points(HERE, NOTHING)) == len(layer.points)


def seen(pose: Pose2, scan: Scan = NOTHING) -> ControlInput:
    return ControlInput(pose, AT_REST, scan, np.zeros((0, 2)), touched=False, tick=0)


def path_to(known: NavigationMap, x: float, y: float, start: Pose2 = HERE) -> Path:
    path = plan_to(known, (start.x, start.y), (x, y))
    assert path is not None
    return path


def velocity_towards(x: float, scan: Scan) -> Velocity | None:
    """Return the velocity to a point ahead over open floor."""
    known = open_floor()
    return ArcController(setup_for(known)).follow(path_to(known, x, 0.0), seen(HERE, scan), stops=True)


def test_the_controller_drives_to_the_goal() -> None:
    known = open_floor()
    path, controller, pose = path_to(known, -1.0, 1.0), ArcController(setup_for(known)), HERE
    for _ in range(100):
        velocity = controller.follow(path, seen(pose), stops=True)
        assert velocity is not None
        turn = velocity.angular * 0.1
        chord = velocity.linear * 0.1 * math.cos(turn / 2)
        pose = pose.compose(Pose2(chord, chord * math.tan(turn / 2), turn))
    assert pose.distance(-1.0, 1.0) < 0.01


def test_accelerations_and_speed_are_limited() -> None:
    ramp = Ramp(BASE.drive)
    ramp.wanted = Velocity(1.0, 5.0)
    speeds = [ramp.follow() for _ in range(20)]
    assert np.diff([0.0, *(speed.linear for speed in speeds)]).max() <= 0.9 * 0.02 + 1e-9
    assert speeds[-1].angular == pytest.approx(BASE.drive.max_turn_rate)
    velocity = velocity_towards(2.5, NOTHING)
    assert velocity is not None and velocity.linear == pytest.approx(BASE.drive.max_speed)


@pytest.mark.parametrize("at", [0.19, 0.2, 0.25, 0.3])
def test_the_robot_can_stop_before_an_obstacle_in_the_scan_only(at: float) -> None:
    velocity = velocity_towards(2.5, thing_ahead(at))
    speed = 0.0 if velocity is None else velocity.linear
    needed = speed * 0.2 + speed**2 / (2.0 * BASE.drive.max_acceleration)
    assert needed < at - BASE.radius


def test_stray_beams_do_not_stop_the_robot() -> None:
    """Every fourth beam ends before the robot, its neighbours do not."""
    ranges = np.full(360, 3.0)
    ranges[::4] = 0.25
    velocity = velocity_towards(2.5, scan_of(ranges))
    assert velocity is not None and velocity.linear == pytest.approx(BASE.drive.max_speed)


def test_a_thin_pole_in_the_scan_only_slows_the_robot_down() -> None:
    ranges = np.full(360, 3.0)
    ranges[np.abs(ANGLES) < math.atan2(0.015, 0.2)] = 0.2  # 3 cm wide
    velocity = velocity_towards(2.5, scan_of(ranges))
    assert velocity is None or velocity.linear < 0.1


def test_a_walled_in_robot_is_blocked() -> None:
    ranges = np.full(360, 0.19)
    assert velocity_towards(2.0, scan_of(ranges)) is None


def test_the_controller_respects_the_turn_rate_limit() -> None:
    slow = BASE.model_copy(update={"drive": BASE.drive.model_copy(update={"max_turn_rate": 0.4})})
    controller = ArcController(setup_for(open_floor(), slow))
    velocity = controller.follow(path_to(open_floor(), 0.0, -2.0), seen(HERE), stops=True)
    assert velocity is not None and velocity.linear == 0.0
    assert velocity.angular == pytest.approx(-0.4)


@pytest.mark.parametrize("seed", range(4))
def test_free_lengths_are_those_of_small_steps(seed: int) -> None:
    random = np.random.default_rng(seed)
    x, y = random.uniform(-0.8, 0.8, (2, 12))
    curvatures, radius = np.array([-5.0, -1.0, 0.0, 0.4, 3.0]), 0.18
    apart = np.hypot(x, y) > radius
    x, y = x[apart], y[apart]
    steps = np.arange(0.0, 0.9, 1e-4)
    ax, ay = arc_points(curvatures[:, None], steps)
    touches = (np.hypot(ax[..., None] - x, ay[..., None] - y) < radius).any(axis=2)
    expected = np.where(touches.any(axis=1), steps[touches.argmax(axis=1)], 0.9)
    around = Points(x, y, np.zeros(len(x), dtype=np.int64))
    assert free_lengths(curvatures[None], around, radius, 0.9)[0] == pytest.approx(expected, abs=3e-4)


def test_a_robot_that_is_too_close_may_leave_but_not_approach() -> None:
    x, y, robot = np.array([0.1]), np.array([0.1]), np.array([0])  # ahead, to the left
    [[ahead, left, right]] = free_lengths(np.array([[0.0, 2.0, -2.0]]), Points(x, y, robot), 0.18, 1.0)
    assert (ahead, left, right) == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    behind = Points(-x, y, robot)
    assert free_lengths(np.array([[0.0, -2.0]]), behind, 0.18, 1.0).tolist() == [[1.0, 1.0]]


@pytest.mark.parametrize("seed", range(5))
def test_the_map_has_the_distance_of_each_cell_to_the_nearest_wall(seed: int) -> None:
    chance = np.random.default_rng(seed)
    places = chance.uniform(-3.0, 3.0, (1 + 2 * seed, 3))
    walls = [Wall("w", float(x), float(y), float(yaw), 1.0, 0.1, 0.5) for x, y, yaw in places]
    nearest = np.min([build_map(EXTENT, [wall]).distance for wall in walls], axis=0)
    known = build_map(EXTENT, walls)
    assert np.array_equal(known.distance, nearest)
