from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from seoro.bridges.wire import GET_RELATIVE_POSE, SET_ENTITY_STATE, RelativePose, SetEntityState
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.localisation import ASTRAY_SHARE, Localisation
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.motion_models import move_anywhere, move_forwards
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.robots.declaration import LocalisationDeclaration, MobileDeclaration
from sim_nodes.robots.reading import load_robot
from sim_nodes.sensors.lidar import Scan
from tests.sampling import sampled
from tests.sim_nodes.client import ROBOT, TRUTH, Client, pose


def base(**localisation: float) -> MobileDeclaration:
    """Return the base of the TurtleBot with other parameters of its localisation."""
    declared = load_robot("turtlebot4").mobile
    assert declared is not None
    return declared.model_copy(update={"localisation": declared.localisation.model_copy(update=localisation)})


BASE = base()
HERE = Pose2(0.0, 0.0, 0.0)


def test_the_localisation_stays_within_bounds_while_driving(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, -1.5))
    errors = []
    for _ in range(40):
        maze.advance(maze.simulator.simulation.time + 0.5)
        errors.append(maze.estimate.distance(maze.truth.x, maze.truth.y))
    assert maze.truth.distance(0.0, 0.0) > 1.0
    assert float(np.mean(errors)) < 0.05
    assert max(errors) < 0.12


def test_a_wrong_initial_pose_is_corrected_by_the_scans(maze: Client) -> None:
    maze.localise(pose(0.1, -0.1, 0.05))
    assert maze.estimate.distance(0.1, -0.1) < 1e-9
    maze.navigate(pose(1.5, 1.5))
    maze.run_until("goal")
    assert maze.estimate.distance(maze.truth.x, maze.truth.y) < 0.08


def test_without_scans_that_fit_the_odometry_carries_the_estimate() -> None:
    localisation = Localisation(build_map((-5, -5, 5, 5), ()), BASE, Noise(0, "test"))
    odometry = Pose2(1.0, 0.0, 0.0)
    assert localisation.pose(odometry) is None
    assert localisation.map_to_odom() is None
    localisation.set_initial_pose(Pose2(0.0, 2.0, math.pi / 2), odometry, 0)
    moved = localisation.pose(Pose2(2.0, 0.0, 0.0))
    assert moved is not None
    assert moved.distance(0.0, 3.0) < 1e-9


def test_a_scan_without_returns_moves_no_particles() -> None:
    localisation = Localisation(build_map((-5, -5, 5, 5), ()), BASE, Noise(0, "test"))
    localisation.set_initial_pose(Pose2(0.0, 2.0, 0.0), HERE, 0)
    nothing = np.full(360, np.inf)
    localisation.update(HERE, Scan(nothing, np.linspace(-math.pi, math.pi, 360), HERE, nothing, nothing), 5)
    found = localisation.pose(HERE)
    assert found is not None and found.distance(0.0, 2.0) < 0.05


def test_beams_that_end_beyond_the_map_are_alike_on_all_sides() -> None:
    known = build_map((-1, -1, 1, 2), (Wall("w", 0.0, 1.9, 0.0, 2.0, 0.2, 0.5),))
    localisation = Localisation(known, BASE, Noise(0, "test"))
    far = [(-9.0, 0.0), (9.0, 0.0), (0.0, -9.0), (0.0, 9.0), (-9.0, 1.9), (9.0, 9.0), (0.0, 1.9)]
    localisation.particles = np.array([(x, y, 0.0) for x, y in far])
    *beyond, wall = localisation._log_likelihood.take(localisation._ends(np.zeros(1), np.zeros(1)))[0]
    assert len(set(beyond)) == 1 and wall > beyond[0]


def test_the_frame_of_odometry_is_computed_once_for_an_estimate() -> None:
    localisation = Localisation(build_map((-5, -5, 5, 5), ()), BASE, Noise(0, "test"))
    localisation.set_initial_pose(Pose2(1.0, 0.0, 0.0), Pose2(0.0, 0.0, 0.0), 0)
    first, state = localisation.map_to_odom(), localisation.save()
    assert localisation.map_to_odom() is first
    localisation.set_initial_pose(Pose2(3.0, 0.0, 0.0), Pose2(1.0, 0.0, 0.0), 1)
    assert localisation.map_to_odom() == Pose2(2.0, 0.0, 0.0)
    localisation.restore(state)
    assert localisation.map_to_odom() == first


def test_frames_distinguish_the_estimate_from_the_truth(empty: Client) -> None:
    empty.localise(pose(2.0, 1.0, math.pi / 2))

    def ahead(frame: str, parent: str = "map") -> tuple[float, float, float]:
        found = empty.ask(GET_RELATIVE_POSE, RelativePose(frame=frame, parent_frame=parent, distance=1.0))
        return round(found.position.x, 3), round(found.position.y, 3), round(found.orientation.yaw, 3)

    assert ahead(f"{ROBOT}/base_link") == (2.0, 2.0, 1.571)
    assert ahead("base_link", "odom") == (1.0, 0.0, 0.0)
    assert ahead(TRUTH) == (1.0, 0.0, 0.0)


def drive_and_keep(client: Client, steps: int) -> list[tuple[int, Pose2, Scan, Pose2]]:
    """Drive; return tick, odometry, scan and localised pose of each scan."""
    robot = client.simulator.simulation.robot(ROBOT).mobile
    kept = []
    update = robot.localisation.update

    def keeping(odometry: Pose2, scan: Scan, tick: int) -> None:
        update(odometry, scan, tick)
        found = robot.localisation.pose(odometry)
        assert found is not None
        kept.append((tick, odometry, scan, found))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(robot.localisation, "update", keeping)
        for _ in range(steps):
            client.advance(client.simulator.simulation.time + 0.5)
    return kept


def test_localisation_uses_only_odometry_and_scans(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, -1.5))
    kept = drive_and_keep(maze, 12)
    world = maze.simulator.simulation.world
    alone = Localisation(build_map(world.extent, world.walls), BASE, Noise(0, f"{ROBOT}/localisation"))
    alone.set_initial_pose(Pose2(0.0, 0.0, 0.0), Pose2(0.0, 0.0, 0.0), 0)
    for tick, odometry, scan, expected in kept:
        alone.update(odometry, scan, tick)
        assert alone.pose(odometry) == expected
    assert kept[-1][3].distance(0.0, 0.0) > 0.5


def test_the_number_of_particles_follows_their_spread(maze: Client) -> None:
    maze.localise()
    localisation = maze.simulator.simulation.robot(ROBOT).mobile.localisation
    parameters = BASE.localisation
    assert len(localisation.particles) == parameters.max_particles
    maze.navigate(pose(1.5, 1.5))
    maze.advance(2.0)
    assert len(localisation.particles) == parameters.min_particles
    estimate = localisation.estimate
    assert estimate is not None and estimate.share == 1.0 and estimate.deviation < 0.1


def test_beams_beyond_the_map_reduce_the_weight_of_a_pose() -> None:
    """Otherwise, a robot that heads for the border would match walls outside."""
    known = build_map((-3.0, -3.0, 3.0, 3.0), (Wall("w", 2.95, 0.0, math.pi / 2, 6.0, 0.1, 0.5),))
    localisation = Localisation(known, BASE, Noise(0, "test"))
    localisation.set_initial_pose(Pose2(1.0, 0.0, 0.0), Pose2(0.0, 0.0, 0.0), 0)
    angles = np.linspace(-0.3, 0.3, 60)
    ranges = 1.9 / np.cos(angles)
    scan = Scan(ranges, angles, Pose2(0.0, 0.0, 0.0), ranges * np.cos(angles), ranges * np.sin(angles))
    for tick in range(1, 8):
        localisation.update(Pose2(0.0, 0.0, 0.12 * (tick % 2)), scan, tick)
    found = localisation.estimate
    assert found is not None
    assert abs(found.pose.x - 1.0) < 0.1


@pytest.mark.parametrize("seed", sampled(range(3), every=3))
def test_a_global_search_finds_the_pose(seed: int) -> None:
    client = Client("maze", seed=seed)
    x, y, yaw = ((-4.5, -3.0, 1.0), (1.5, -1.5, -2.0), (0.2, 1.6, 0.3))[seed]
    client.ask(SET_ENTITY_STATE, SetEntityState(name=ROBOT, pose=pose(x, y, yaw, z=0.001)))
    robot = client.simulator.simulation.robot(ROBOT).mobile
    robot.localisation.search(robot.odometry.pose, 1)
    assert robot.localised_pose() is None
    assert len(robot.localisation.particles) == BASE.localisation.global_particles
    client.simulator.simulation.engine.command_wheels(ROBOT, -2.6, 2.6)
    while robot.localised_pose() is None and client.simulator.simulation.time < 24.0:
        client.advance(client.simulator.simulation.time + 0.1)
    found, truth = robot.localised_pose(), client.truth
    assert found is not None and found.distance(truth.x, truth.y) < 0.15


def test_a_search_rejects_a_place_that_only_looks_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """All particles are at a wrong place at first: the scan does not fit, so the search restarts."""
    walls = (Wall("a", 0.0, 2.9, 0.0, 5.8, 0.1, 0.5), Wall("b", 2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5))
    known = build_map((-3.0, -3.0, 3.0, 3.0), walls)
    localisation = Localisation(known, BASE, Noise(0, "test"))
    truth, wrong = Pose2(-1.5, 1.0, 0.3), Pose2(1.5, 1.5, 0.0)
    searched: list[Pose2] = []

    def anywhere(count: int, random: np.random.Generator) -> NDArray[np.float64]:
        searched.append(truth if searched else wrong)
        return np.array(searched[-1]) + random.normal(0.0, 0.02, (count, 3))

    monkeypatch.setattr(localisation, "_random_poses", anywhere)
    localisation.search(Pose2(0.0, 0.0, 0.0), 0)
    localisation.update(Pose2(0.0, 0.0, 0.0), seen(known, truth), 1)
    assert localisation.estimate is None, "it has found itself where the scan does not fit"
    assert searched == [wrong, truth]
    localisation.update(Pose2(0.0, 0.0, 0.12), seen(known, Pose2(-1.5, 1.0, 0.42)), 2)
    assert localisation.estimate is not None
    assert localisation.estimate.pose.distance(truth.x, truth.y) < 0.1


def test_random_particles_relocalise_a_carried_robot_if_enabled() -> None:
    """The scans do not fit the initial pose; only some random particles can fit them."""
    walls: tuple[Wall, ...] = (
        Wall("a", 0.0, 2.9, 0.0, 5.8, 0.1, 0.5),
        Wall("b", 2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5),
    )
    walls += (Wall("c", -1.0, -1.0, 0.4, 2.0, 0.1, 0.5), Wall("d", 1.2, -2.0, 1.2, 1.0, 0.1, 0.5))
    known = build_map((-3.0, -3.0, 3.0, 3.0), walls)

    def error(**parameters: float) -> float:
        localisation = Localisation(known, base(max_particles=5000, **parameters), Noise(0, "test"))
        localisation.set_initial_pose(Pose2(1.5, 1.5, 0.0), Pose2(0.0, 0.0, 0.0), 0)
        for tick in range(1, 60):
            truth = Pose2(1.5, 1.5, 0.12 * tick) if tick < 10 else Pose2(-1.5, 1.0, 0.12 * tick)
            localisation.update(Pose2(0.0, 0.0, 0.12 * tick), seen(known, truth), tick)
        assert localisation.estimate is not None
        return localisation.estimate.pose.distance(-1.5, 1.0)

    assert error() > 1.0
    assert error(recovery_alpha_slow=0.001, recovery_alpha_fast=0.1) < 0.3


ROOM = (
    Wall("a", 0.0, 2.9, 0.0, 5.8, 0.1, 0.5),
    Wall("b", 2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5),
    Wall("c", -1.0, -1.0, 0.4, 2.0, 0.1, 0.5),
    Wall("d", 1.2, -2.0, 1.2, 1.0, 0.1, 0.5),
    Wall("e", -2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5),
)


def drive_on(turned: float, wrong_beams: float = 0.0) -> tuple[Pose2, Localisation]:
    """Drive and localise a robot that is turned by an angle [rad] unseen by odometry."""
    known = build_map((-3.0, -3.0, 3.0, 3.0), ROOM)
    localisation = Localisation(known, BASE, Noise(0, "test"))
    truth, odometry, step = Pose2(-1.5, 1.0, 0.0), Pose2(0.0, 0.0, 0.0), Pose2(0.11, 0.0, 0.0)
    localisation.set_initial_pose(truth, odometry, 0)
    random = np.random.default_rng(0)
    for tick in range(1, 13):
        truth, odometry = truth.compose(step), odometry.compose(step)
        if tick == 5:
            truth = truth.compose(Pose2(0.0, 0.0, turned))
        localisation.update(odometry, disturbed(seen(known, truth), wrong_beams, random), tick)
    return truth, localisation


def disturbed(scan: Scan, share: float, random: np.random.Generator) -> Scan:
    """Return the scan with a share of its beams shortened at random."""
    wrong = random.random(len(scan.ranges)) < share
    ranges = np.where(wrong, scan.ranges * random.uniform(0.1, 0.8, len(scan.ranges)), scan.ranges)
    ends = (
        np.where(np.isfinite(ranges), ranges, 0.0) * turn for turn in (np.cos(scan.angles), np.sin(scan.angles))
    )
    x, y = (np.where(np.isfinite(ranges), end, np.inf) for end in ends)
    return Scan(ranges, scan.angles, scan.mount, x, y)


@pytest.mark.parametrize("turned", [0.7, -1.0])
def test_a_robot_turned_by_a_wall_recovers_its_heading(turned: float) -> None:
    """Its wheels slipped: all particles have about the old heading."""
    truth, localisation = drive_on(turned)
    found = localisation.estimate
    assert found is not None
    assert abs(found.pose.yaw - truth.yaw) < 0.1
    assert found.pose.distance(truth.x, truth.y) < 0.15


def test_beams_on_unmapped_objects_do_not_move_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Most beams fit nowhere, so no nearby pose is better than the right one."""
    looked: list[float] = []
    misfit = Localisation._misfit

    def counted(self: Localisation, pose: Pose2, scan: Scan) -> float:
        looked.append(misfit(self, pose, scan))
        return looked[-1]

    monkeypatch.setattr(Localisation, "_misfit", counted)
    _, found = drive_on(turned=0.0, wrong_beams=0.7)
    assert max(looked) > ASTRAY_SHARE, "it has never looked around"
    monkeypatch.setattr(Localisation, "_try_nearby_poses", lambda *_: None)
    _, expected = drive_on(turned=0.0, wrong_beams=0.7)
    assert found.particles.tolist() == expected.particles.tolist()


def seen(known: NavigationMap, at: Pose2) -> Scan:
    """Return a scan without noise, by rays marched through the map."""
    angles = np.linspace(-math.pi, math.pi, 60, endpoint=False)
    steps = np.arange(0.05, 6.0, 0.02)[None, :]
    x = at.x + steps * np.cos(at.yaw + angles)[:, None]
    y = at.y + steps * np.sin(at.yaw + angles)[:, None]
    hit = (known.distance[known.grid.cells(x, y)] < 0.03) & known.grid.inside(x, y)
    ranges = np.where(hit.any(axis=1), steps[0, hit.argmax(axis=1)], np.inf)
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    ends = (np.where(np.isfinite(ranges), finite * turn, np.inf) for turn in (np.cos(angles), np.sin(angles)))
    return Scan(ranges, angles, Pose2(0.0, 0.0, 0.0), *ends)


def test_moving_sideways_keeps_the_heading_of_particles() -> None:
    spreads = []
    for move in (move_forwards, move_anywhere):
        particles = np.zeros((2000, 3))
        move(particles, Pose2(0.0, 0.1, 0.0), LocalisationDeclaration(), np.random.default_rng(0))
        assert particles[:, :2].mean(axis=0) == pytest.approx((0.0, 0.1), abs=0.03)
        spreads.append(float(particles[:, 2].std()))
    assert spreads[0] > 0.3  # a robot that turns to the side and back
    assert spreads[1] < 0.05
