"""Robots that are computed together have the numbers of each one alone."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path as File

import numpy as np
import pytest

from sim_nodes.check.bench import LIDAR
from sim_nodes.geometry import Pose2
from sim_nodes.navigation import controller as arcs
from sim_nodes.navigation import decisions
from sim_nodes.navigation.contracts import ControlInput, Following, Path
from sim_nodes.navigation.controller import ArcController, follow_together
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.obstacles import Observation, ObstacleLayer, update_together
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.sensors.lidar import Lidar, Scan, read_together
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.engines import make_engine
from tests.sim_nodes.plans import plan_to, setup_for

NAMES = ("turtlebot4", "second", "third", "fourth", "fifth")
EXTENT = (-3.0, -3.0, 3.0, 3.0)
WORLD = """
name: crowd
extent: [-3, -3, 3, 3]
walls: [{points: [[-2, -1], [2, -1], [2, 1], [-2, 1], [-2, -1]]}]
robots:
  - {name: turtlebot4, robot: turtlebot4}
  - {name: second, robot: turtlebot4, pose: {x: 1.0, yaw: 2.0}}
  - {name: third, robot: turtlebot4, pose: {x: -1.0, y: 0.3, yaw: 1.0}}
  - {name: fourth, robot: turtlebot4, pose: {x: -1.4, y: -0.4, yaw: -2.0}}
  - {name: fifth, robot: turtlebot4, pose: {x: 0.6, y: 0.6, yaw: 3.0}}
"""


@pytest.fixture
def crowd(tmp_path: File) -> Simulation:
    file = tmp_path / "world.yaml"
    file.write_text(WORLD, encoding="utf-8")
    simulation = Simulation(make_engine("mujoco"), load_world(str(file)), 3)
    simulation.run(0.2)
    return simulation


def room() -> NavigationMap:
    return build_map(EXTENT, (Wall("w", 0.0, -0.5, math.pi / 2, 5.0, 0.1, 0.5),))


def random_scan(random: np.random.Generator, *, walled_in: bool) -> Scan:
    """Return a scan of things at some distances, with lost beams, or of a close ring."""
    angles = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    ranges = np.repeat(random.uniform(0.25, 2.0, 12), 30) + random.normal(0.0, 0.01, 360)
    ranges[random.random(360) < random.choice([0.0, 0.1, 0.999])] = np.inf
    if walled_in:
        ranges[:] = 0.19
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    ends = (np.where(np.isfinite(ranges), -0.04 + finite * np.cos(angles), np.inf), finite * np.sin(angles))
    return Scan(ranges, angles, Pose2(-0.04, 0.0, 0.0), *ends)


def random_calls(known: NavigationMap) -> list[Following[ArcController]]:
    calls = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        x, y = random.uniform((-2.5, -2.5), (-0.5, 2.5)).tolist()
        path = plan_to(known, (x, y), (1.5, float(random.uniform(-2.0, 2.0))))
        assert isinstance(path, Path)
        pose = Pose2(x, y, float(path.poses[0, 2] + random.uniform(-1.0, 1.0) * (seed > 1)))
        remembered = np.array([x, y]) + random.uniform(-0.6, 0.6, (random.integers(0, 3), 2))
        now = ControlInput(
            pose, AT_REST, random_scan(random, walled_in=seed < 2), remembered, touched=False, tick=0
        )
        calls.append(Following(ArcController(setup_for(known)), path, now, bool(seed % 2)))
    return calls


def test_controllers_drive_together_as_alone() -> None:
    known = room()
    together, alone = random_calls(known), random_calls(known)
    for _ in range(3):  # controllers have a state
        velocities = follow_together(together)
        assert velocities == [call.controller.follow(call.path, call.now, stops=call.stops) for call in alone]
    kinds = [None if velocity is None else velocity.linear > 0.0 for velocity in velocities]
    assert {None, True, False} == set(kinds)


def test_controllers_of_a_kind_are_computed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rated: list[int] = []
    rate = ArcController.rate_arcs

    def counted(self: ArcController, aheads: list[arcs.Ahead], calls: list[Following[ArcController]]) -> arcs.Arcs:
        rated.append(len(calls))
        return rate(self, aheads, calls)

    monkeypatch.setattr(ArcController, "rate_arcs", counted)
    known = room()
    follow_together(random_calls(known))
    assert len(rated) == 1


def test_classes_below_a_controller_are_asked_themselves() -> None:
    class Still(ArcController):
        def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
            return None

    call = random_calls(room())[0]
    assert decisions._velocities([call, replace(call, controller=Still(setup_for(room())))])[1] is None


@pytest.mark.parametrize(("dropout", "resolution"), [(0.0, 0.0), (0.2, 0.01)])
def test_scans_are_read_together_as_alone(crowd: Simulation, dropout: float, resolution: float) -> None:
    declared = LIDAR.model_copy(update={"dropout": dropout, "resolution": resolution})
    other = LIDAR.model_copy(update={"beams": 90})
    lidars = [Lidar(other if name == "third" else declared, Noise(0, name), name, crowd.engine) for name in NAMES]
    for tick in (5, 10):
        for found, lidar in zip(read_together(lidars, tick), lidars, strict=True):
            alone = lidar.read(tick)
            for name in ("ranges", "angles", "x", "y"):
                np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))
    assert len(read_together(lidars, 5)[2].ranges) == 90


def layer_steps(known: NavigationMap, seed: int) -> list[tuple[Pose2, Scan]]:
    """Return poses of a robot and scans there, some with a thing that appears and leaves again."""
    random = np.random.default_rng(seed)
    angles = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    steps = []
    for number in range(14):
        pose = Pose2(-1.5 + 0.05 * number, float(random.uniform(-0.5, 0.5)), float(random.uniform(-1.0, 1.0)))
        ranges = np.full(360, 1.2) + random.normal(0.0, 0.01, 360)
        ranges[(np.abs(angles) < 0.3) & (3 <= number % 10 <= 8)] = 0.5 + 0.1 * seed
        ranges[random.random(360) < 0.05 * (seed % 3)] = np.inf
        finite = np.where(np.isfinite(ranges), ranges, 0.0)
        ends = (np.where(np.isfinite(ranges), finite * turn(angles), np.inf) for turn in (np.cos, np.sin))
        steps.append((pose, Scan(ranges, angles, Pose2(-0.04, 0.0, 0.0), *ends)))
    return steps


def test_obstacles_are_updated_together_as_alone() -> None:
    known = room()
    together, alone = [ObstacleLayer(known) for _ in range(5)], [ObstacleLayer(known) for _ in range(5)]
    steps = [layer_steps(known, seed) for seed in range(5)]
    seen = set()
    for at in range(14):
        some = [number for number in range(5) if (at + number) % 4]  # not all have a scan
        update_together([Observation(together[number], *steps[number][at]) for number in some])
        for number in some:
            alone[number].update(*steps[number][at])
        for one, other in zip(together, alone, strict=True):
            assert one.changes == other.changes
            np.testing.assert_array_equal(one.points, other.points)
            for name in ("_cells", "_counts", "_places"):
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
            seen.add(len(one.points) > 0)
    assert seen == {True, False}
    assert max(layer.changes for layer in together) > 3
