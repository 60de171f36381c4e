"""Plans over poses, for cars and for robots that are not round."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.check.drives import robot_with
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.navigation.contracts import InvalidParameter, Path, PlanRequest, Setup
from sim_nodes.navigation.cover import Cover, cover_of, polygon_cover
from sim_nodes.navigation.hybrid import HybridPlanner
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.plugins import default_plugins
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive_declaration import DriveKind, PlanarDrive
from sim_nodes.robots.footprint import Footprint
from sim_nodes.robots.navigation import Parameter

EXTENT = (-3.0, -3.0, 3.0, 3.0)
LONG = Footprint(((0.5, 0.15), (-0.5, 0.15), (-0.5, -0.15), (0.5, -0.15)))  # 1.0 by 0.3 m
CAR = Footprint(((0.5, 0.15), (-0.1, 0.15), (-0.1, -0.15), (0.5, -0.15)))
OPEN = build_map(EXTENT, ())


def base_of(kind: DriveKind, footprint: Footprint = LONG) -> MobileDeclaration:
    declared = robot_with(kind).mobile
    assert declared is not None
    radius = footprint.radius
    return declared.model_copy(update={"footprint": footprint, "radius": radius, "clearance": radius + 0.02})


SKID, ACKERMANN = base_of(DriveKind.SKID_STEER), base_of(DriveKind.ACKERMANN, CAR)


def door(width: float) -> NavigationMap:
    """Return a room with a door in the wall across its middle."""
    length = 3.0 - width / 2
    middle = width / 2 + length / 2
    walls = [Wall("w", 0.0, sign * middle, math.pi / 2, length, 0.1, 0.5) for sign in (-1.0, 1.0)]
    return build_map(EXTENT, walls)


def plan(
    declaration: MobileDeclaration,
    known: NavigationMap,
    start: tuple[float, float, float],
    goal: tuple[float, float, float],
    **parameters: Parameter,
) -> Path | None:
    planner = HybridPlanner(Setup(declaration, known, parameters, Noise(0, "test")))
    return planner.plan(PlanRequest(known.grid, known.distance, Pose2(*start), Pose2(*goal), 0))


def least_gap(cover: Cover, known: NavigationMap, poses: Array) -> float:
    return float(cover.disc_gaps(known.grid, known.distance, poses).min())


def test_discs_cover_the_outline_and_no_more_than_the_margin() -> None:
    cover = polygon_cover(LONG, 0.02)
    chance = np.random.default_rng(0)
    x, y = chance.uniform(-0.7, 0.7, (2, 20_000))
    inside = (np.abs(x) <= 0.5) & (np.abs(y) <= 0.15)
    beyond = np.hypot(np.maximum(np.abs(x) - 0.5, 0.0), np.maximum(np.abs(y) - 0.15, 0.0))
    gaps = cover.gaps_to(x, y, np.zeros((1, 3)))[0]
    assert gaps[inside].max() <= 0.0
    assert beyond[gaps < 0.0].max() <= 0.02 + 1e-9
    assert cover.reach <= LONG.radius + 0.02 + 1e-9


def test_round_robots_are_one_disc() -> None:
    assert cover_of(BASE).discs.tolist() == [[0.0, 0.0, BASE.clearance]]


@pytest.mark.parametrize(
    ("declaration", "plugins"),
    [
        (BASE, ("grid", "arcs")),
        (SKID, ("hybrid", "pursuit")),
        (ACKERMANN, ("hybrid", "pursuit")),
        (robot_with(DriveKind.OMNIDIRECTIONAL).mobile, ("grid", "holonomic")),
        (base_of(DriveKind.OMNIDIRECTIONAL), ("hybrid", "holonomic")),
    ],
)
def test_drive_and_outline_choose_planner_and_controller(
    declaration: MobileDeclaration, plugins: tuple[str, str]
) -> None:
    planner, controller = default_plugins(declaration)
    assert (planner.plugin, controller.plugin) == plugins


def test_a_long_robot_passes_a_door_that_its_circle_does_not() -> None:
    known = door(0.6)  # 1.0 m long, so that its circle is 1.04 m wide
    path = plan(SKID, known, (-1.5, 1.0, math.pi / 2), (1.5, -1.0, 0.0))
    assert path is not None
    assert least_gap(cover_of(SKID), known, path.poses) >= -1e-9
    assert path.poses[0] == pytest.approx((-1.5, 1.0, math.pi / 2))
    assert path.poses[-1] == pytest.approx((1.5, -1.0, 0.0))
    assert path.to_go[0] < 1.15 * math.hypot(3.0, 2.0)


def test_a_door_that_is_too_narrow_has_no_path() -> None:
    assert plan(SKID, door(0.3), (-1.5, 1.0, 0.0), (1.5, -1.0, 0.0)) is None


def test_a_robot_does_not_turn_where_its_corners_hit() -> None:
    """In a corridor of 0.7 m, a robot of 1.0 m cannot turn round: it drives out to turn, or backwards."""
    walls = [Wall("w", 0.0, sign * 0.4, 0.0, 2.4, 0.1, 0.5) for sign in (-1.0, 1.0)]
    known = build_map(EXTENT, walls)
    path = plan(SKID, known, (0.0, 0.0, 0.0), (0.3, 0.0, -3.1))
    assert path is not None
    assert path.to_go[0] > 1.5
    assert least_gap(cover_of(SKID), known, path.poses) >= -1e-9


def test_a_car_changes_direction_to_turn_round() -> None:
    path = plan(ACKERMANN, OPEN, (0.0, 0.0, 0.0), (0.0, 0.0, math.pi))
    assert path is not None
    assert {-1, 1} == set(path.ways.tolist())
    drive = ACKERMANN.drive
    assert isinstance(drive, PlanarDrive)
    steps, turned = np.diff(path.points, axis=0), np.abs(wrap(np.diff(path.poses[:, 2])))
    assert (turned <= np.hypot(*steps.T) / drive.min_turning_radius + 1e-3).all()


def test_a_car_drives_a_short_way_backwards() -> None:
    path = plan(ACKERMANN, OPEN, (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert path is not None
    assert set(path.ways.tolist()) == {-1}
    assert path.to_go[0] == pytest.approx(1.0, abs=0.02)


def test_a_larger_turning_radius_makes_longer_paths() -> None:
    lengths = []
    for radius in (0.1, 1.5):
        path = plan(ACKERMANN, OPEN, (0.0, 0.0, 0.0), (0.0, 1.0, 3.1), minimum_turning_radius=radius)
        assert path is not None
        lengths.append(float(path.to_go[0]))
    assert lengths[1] > lengths[0] + 0.5


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        (
            {"radius": 1.0},
            "unknown parameter `radius`; expected one of change_penalty, minimum_turning_radius, rev",
        ),
        ({"reverse_penalty": 0.5}, "invalid `reverse_penalty` 0.5; expected 1 or more"),
        ({"change_penalty": "high"}, "invalid `change_penalty` 'high'; expected a number from 0 to 1000"),
    ],
)
def test_invalid_parameters_are_refused(parameters: dict[str, Parameter], words: str) -> None:
    with pytest.raises(InvalidParameter, match=words):
        plan(ACKERMANN, OPEN, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), **parameters)
