"""Planners and controllers with all drives and outlines: each combination works, or is refused with a reason."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest

from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.check.bench import TURTLEBOT
from sim_nodes.check.drives import robot_with
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.navigation.contracts import Path, PlanRequest
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.hybrid import HybridPlanner
from sim_nodes.navigation.maps import build_map
from sim_nodes.navigation.navigator import Navigator
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.noise import Noise
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.declaration import MobileDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.footprint import Footprint
from sim_nodes.robots.navigation import PluginDeclaration
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.engines import MUJOCO_FIRST, make_engine
from tests.sim_nodes.test_recovery import HERE

KNOWN = build_map((-3.0, -3.0, 3.0, 3.0), ())
OUTLINE = Footprint(((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)))
TURNING = (DriveKind.DIFFERENTIAL, DriveKind.SKID_STEER)
WORKING = {
    *product(TURNING, ("round",), ("grid", "hybrid"), ("arcs", "pursuit")),
    *product(TURNING, ("polygon",), ("grid",), ("arcs", "pursuit")),
    *product(TURNING, ("polygon",), ("hybrid",), ("pursuit",)),
    *product((DriveKind.OMNIDIRECTIONAL,), ("round",), ("grid", "hybrid"), ("arcs", "holonomic")),
    *product((DriveKind.OMNIDIRECTIONAL,), ("polygon",), ("grid",), ("arcs", "holonomic")),
    *product((DriveKind.OMNIDIRECTIONAL,), ("polygon",), ("hybrid",), ("holonomic",)),
    *product((DriveKind.ACKERMANN,), ("round", "polygon"), ("hybrid",), ("pursuit",)),
}
DEFAULTS = {  # tested elsewhere
    (DriveKind.DIFFERENTIAL, "round", "grid", "arcs"),
    (DriveKind.DIFFERENTIAL, "polygon", "hybrid", "pursuit"),
    (DriveKind.OMNIDIRECTIONAL, "round", "grid", "holonomic"),
    (DriveKind.OMNIDIRECTIONAL, "polygon", "hybrid", "holonomic"),
}
MADE = (DriveKind.DIFFERENTIAL, DriveKind.OMNIDIRECTIONAL)
Combination = tuple[DriveKind, str, str, str]


def robot_of(combination: Combination) -> RobotDeclaration:
    """Return a robot with a drive and outline, a planner and a controller."""
    kind, outline, planner, controller = combination
    declared = TURTLEBOT if kind is DriveKind.DIFFERENTIAL else robot_with(kind)
    assert declared.mobile is not None
    plugins = {"planner": PluginDeclaration(plugin=planner), "controller": PluginDeclaration(plugin=controller)}
    update = {
        "footprint": OUTLINE if outline == "polygon" else None,
        "radius": OUTLINE.radius,
        "clearance": OUTLINE.radius + 0.02,
        "navigation": declared.mobile.navigation.model_copy(update=plugins),
    }
    return declared.model_copy(update={"mobile": declared.mobile.model_copy(update=update)})


def navigator_of(base: MobileDeclaration | None) -> Navigator:
    assert base is not None
    return Navigator(KNOWN, ObstacleLayer(KNOWN), base, Noise(0, "test"))


@pytest.mark.parametrize(
    "combination",
    list(product(DriveKind, ("round", "polygon"), ("grid", "hybrid"), ("arcs", "pursuit", "holonomic"))),
)
def test_a_combination_is_accepted_or_refused(combination: Combination) -> None:
    base = robot_of(combination).mobile
    if combination in WORKING:
        navigator_of(base)
    else:
        with pytest.raises(RequestRefused, match=r"; expected (the controller )?[`'](hybrid|pursuit|holonomic)"):
            navigator_of(base)


@pytest.mark.parametrize("engine", MUJOCO_FIRST)
@pytest.mark.parametrize("combination", sorted(each for each in WORKING - DEFAULTS if each[0] in MADE))
def test_robots_arrive_with_every_combination(combination: Combination, engine: str) -> None:
    empty = load_world("empty")
    placed = replace(empty.robots[0], name="mine", declaration=robot_of(combination))
    simulation = Simulation(make_engine(engine), replace(empty, robots=(placed,)), 0)
    start = simulation.frames.true_pose("mine")
    simulation.robot("mine").mobile.set_initial_pose(start, 0)
    goal = start.compose(Pose2(-0.7, 0.6, 2.0))
    simulation.navigate("mine", Goal("goal", (goal,), stop_at_each=True))
    while simulation.robot("mine").goals and simulation.time < 20.0:
        simulation.run(simulation.time + 0.1)
    there = simulation.robot("mine").mobile.localised_pose()  # without walls, errors of the odometry add up
    assert there is not None and there.distance(goal.x, goal.y) < 0.03
    assert abs(wrap(there.yaw - goal.yaw)) < 0.15
    assert simulation.time < 20.0 and simulation.robot("mine").mobile.recoveries == 0


class WithoutHeadings(HybridPlanner):
    """Its paths have no headings."""

    def plan(self, request: PlanRequest) -> Path | None:
        path = super().plan(request)
        return path and Path(path.points)


def test_paths_without_headings_for_a_car_abort_the_goal() -> None:
    """The robot could not arrive with the heading of the goal."""
    planner = f"{__name__}:{WithoutHeadings.__name__}"
    navigator = navigator_of(robot_of((DriveKind.ACKERMANN, "round", planner, "pursuit")).mobile)
    here = Pose2(-1.0, 0.0, 0.0)
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 1.0),), stop_at_each=False), here)
    ended = navigator.decide(replace(HERE, pose=here))
    assert isinstance(ended, GoalResult) and ended.outcome is Outcome.ABORTED
    assert ended.message == f"the planner '{planner}' returned a path without headings; cars need headings"
