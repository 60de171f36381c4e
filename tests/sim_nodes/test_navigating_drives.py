"""Navigation of cars, of robots that are not round, and of omnidirectional ones."""

from __future__ import annotations

from dataclasses import replace
from importlib import util
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.check.bench import BASE
from sim_nodes.check.drives import robot_with
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.navigation.contracts import ControlInput
from sim_nodes.navigation.contracts import Path as Way
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.holonomic import HolonomicController
from sim_nodes.navigation.maps import build_map
from sim_nodes.navigation.pursuit import PursuitController
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.footprint import Footprint
from sim_nodes.robots.kinematics import AT_REST
from sim_nodes.sensors.lidar import Scan
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.client import Client, pose
from tests.sim_nodes.engines import MUJOCO_FIRST, make_engine
from tests.sim_nodes.graph import differences
from tests.sim_nodes.plans import setup_for
from tests.sim_nodes.test_snapshots import restore, save

needs_models = pytest.mark.skipif(util.find_spec("pybullet_data") is None, reason="pybullet_data is not installed")
ROOM = """name: room
extent: [-3, -3, 4, 3]
walls:
  - points: [[-2.9, -2.9], [3.9, -2.9], [3.9, 2.9], [-2.9, 2.9], [-2.9, -2.9]]
  - points: [[1.0, -2.9], [1.0, -0.5]]
  - points: [[1.0, 0.5], [1.0, 2.9]]
robots: [{name: mine, robot: %s, pose: {x: -1.0}}]
"""


def client_in_room(folder: Path, robot: str, engine: str = "mujoco") -> Client:
    (folder / "room.yaml").write_text(ROOM % robot)
    client = Client(str(folder / "room.yaml"), engine=engine)
    client.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="mine", pose=pose(-1.0, 0.0)))
    return client


def navigate(client: Client, *poses: wire.Pose3D, stop_at_each: bool = True) -> None:
    request = wire.NavigateThroughPoses(id="goal", robot="mine", poses=poses, stop_at_each=stop_at_each)
    client.ask(wire.NAVIGATE_THROUGH_POSES, request)


def arrive(client: Client) -> Pose2:
    ended, contacts = client.run_until("goal")
    assert (ended.outcome, ended.message, contacts) == (Outcome.SUCCEEDED, "", [])
    return client.simulator.simulation.frames.true_pose("mine")


@pytest.mark.more
@needs_models
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_car_reaches_a_pose_behind_it(engine: str, tmp_path: Path) -> None:
    client = client_in_room(tmp_path, "racecar", engine)
    navigate(client, pose(-2.0, 0.4, 0.5))
    there = arrive(client)
    assert there.distance(-2.0, 0.4) < 0.05
    assert abs(wrap(there.yaw - 0.5)) < 0.15


@needs_models
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_car_drives_through_a_door_and_poses(engine: str, tmp_path: Path) -> None:
    client = client_in_room(tmp_path, "racecar", engine)
    navigate(client, pose(2.0, 1.0, 1.57), pose(2.5, -1.5, -1.57), stop_at_each=False)
    there = arrive(client)
    assert there.distance(2.5, -1.5) < 0.05


@needs_models
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_rays_pass_through_all_links_of_their_robot(engine: str, tmp_path: Path) -> None:
    """The lidar of the racecar is within a box, which is a link of its own."""
    client = client_in_room(tmp_path, "racecar", engine)
    client.advance(0.5)
    latest = client.simulator.simulation.robot("mine").mobile.sensors["lidar"].latest
    assert latest is not None and latest.data.hit.all()


@needs_models
def test_a_goal_where_a_car_does_not_fit_is_refused(tmp_path: Path) -> None:
    client = client_in_room(tmp_path, "racecar")
    with pytest.raises(
        RequestRefused, match=r"goal \(0.70, 0.90\) with a heading of 0.00 rad is invalid: the outline"
    ):
        navigate(client, pose(0.7, 0.9, 0.0))


@pytest.mark.more
@needs_models
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_forked_car_continues_bit_identically(engine: str, tmp_path: Path) -> None:
    original = client_in_room(tmp_path, "racecar", engine)
    navigate(original, pose(-1.0, 0.4, 0.0))
    original.advance(1.3)
    snapshot, fork = save(original), Client("empty", 99, engine)
    restore(fork, snapshot)
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    assert arrive(original) == arrive(fork)


@needs_models
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_long_robot_drives_through_a_door(engine: str, tmp_path: Path) -> None:
    """The Husky is 1.0 m long and 0.7 m wide; its circle of 1.2 m does not fit through the door of 0.9 m."""
    client = client_in_room(tmp_path, "husky", engine)
    navigate(client, pose(2.5, 0.3, 0.0))
    there = arrive(client)
    assert there.distance(2.5, 0.3) < 0.3  # it has no lidar, and errors of its odometry add up
    believed = client.simulator.simulation.robot("mine").mobile.localised_pose()
    assert believed is not None and believed.distance(2.5, 0.3) < 0.03


def omnidirectional(*, is_round: bool) -> RobotDeclaration:
    declared = robot_with(DriveKind.OMNIDIRECTIONAL)
    assert declared.mobile is not None
    sides = Footprint(((0.36, 0.29), (-0.36, 0.29), (-0.36, -0.29), (0.36, -0.29)))
    update = {"footprint": None if is_round else sides, "radius": sides.radius, "clearance": sides.radius + 0.02}
    return declared.model_copy(update={"mobile": declared.mobile.model_copy(update=update)})


@pytest.mark.parametrize("is_round", [True, False])
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_an_omnidirectional_robot_docks_sideways(engine: str, is_round: bool) -> None:
    empty = load_world("empty")
    placed = replace(empty.robots[0], name="mine", declaration=omnidirectional(is_round=is_round))
    simulation = Simulation(make_engine(engine), replace(empty, robots=(placed,)), 0)
    start = simulation.frames.true_pose("mine")
    simulation.robot("mine").mobile.set_initial_pose(start, 0)
    goal = start.compose(Pose2(0.0, 1.2, 0.4))
    simulation.navigate("mine", Goal("goal", (goal,), stop_at_each=True))
    headings = []
    while simulation.robot("mine").goals and simulation.time < 20.0:
        simulation.run(simulation.time + 0.1)
        headings.append(wrap(simulation.frames.true_pose("mine").yaw - start.yaw))
    there = simulation.frames.true_pose("mine")
    assert there.distance(goal.x, goal.y) < 0.03
    assert headings[-1] == pytest.approx(0.4, abs=0.1)
    assert max(np.abs(headings)) < 0.5  # it never turned to the way
    assert simulation.time < 5.0


LONG = Footprint(((0.5, 0.15), (-0.5, 0.15), (-0.5, -0.15), (0.5, -0.15)))
LONG_BASE = BASE.model_copy(update={"footprint": LONG, "radius": LONG.radius, "clearance": LONG.radius + 0.02})
FLOOR = build_map((-3.0, -3.0, 3.0, 3.0), ())
HERE = Pose2(0.0, 0.0, 0.0)


def seeing(x: float, y: float) -> ControlInput:
    """Return inputs with a thing of 10 cm around a point."""
    angles = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    off = np.abs(wrap(angles - np.arctan2(y, x)))
    near = off < 0.05 / np.hypot(x, y)
    ranges = np.where(near, np.hypot(x, y), np.inf)
    ends = [np.where(near, np.hypot(x, y) * part, np.inf) for part in (np.cos(angles), np.sin(angles))]
    return ControlInput(HERE, AT_REST, Scan(ranges, angles, HERE, *ends), np.zeros((0, 2)), touched=False, tick=0)


TURN = Way(np.zeros((16, 2)), np.linspace(0.0, 1.5, 16))
AHEAD = Way(np.column_stack([np.linspace(0.0, 1.0, 21), np.zeros(21)]), np.zeros(21))


@pytest.mark.parametrize(
    ("path", "thing", "moves"),
    [
        (TURN, (0.48, 0.185), False),  # a corner would hit it
        (TURN, (0.48, -0.185), True),  # the corner leaves it
        (TURN, (0.0, 0.6), True),
        (AHEAD, (0.54, 0.0), False),
        (AHEAD, (0.3, 0.25), True),  # beside it, within its circle
        (AHEAD, (-0.6, 0.0), True),
    ],
)
def test_the_outline_decides_whether_a_robot_may_move(path: Way, thing: tuple[float, float], moves: bool) -> None:
    controller = PursuitController(setup_for(FLOOR, LONG_BASE))
    controller.set_plan(path)
    assert (controller.follow(path, seeing(*thing), stops=True) is not None) is moves


@pytest.mark.parametrize(("thing", "turns"), [((2.0, 0.0), True), ((-0.3, -0.28), False)])
def test_an_omnidirectional_robot_does_not_turn_a_corner_into_a_thing(
    thing: tuple[float, float], turns: bool
) -> None:
    """It brakes before a thing beside the path, so it would turn faster than it moves on."""
    mobile = omnidirectional(is_round=False).mobile
    assert mobile is not None
    ahead = np.linspace(0.0, 1.0, 41)
    path = Way(np.column_stack([ahead, np.zeros(41)]), np.minimum(4.0 * ahead, 1.0))
    controller = HolonomicController(setup_for(FLOOR, LONG_BASE.model_copy(update={"drive": mobile.drive})))
    controller.set_plan(path)
    velocity = controller.follow(path, seeing(*thing), stops=True)
    assert velocity is not None and velocity.linear > 0.05
    assert (velocity.angular > 0.0) is turns
