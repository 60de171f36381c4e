"""Planners and controllers of others: by `module:Class` and entry point, and the checks for them."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import pairwise
from pathlib import Path as File
from typing import ClassVar

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.check.bench import BASE
from sim_nodes.check.drives import robot_with
from sim_nodes.check.navigation import check_controller, check_planner
from sim_nodes.navigation.contracts import (
    ControlInput,
    Controller,
    InvalidParameter,
    Path,
    Planner,
    PlanRequest,
    Setup,
)
from sim_nodes.navigation.controller import ArcController
from sim_nodes.navigation.holonomic import HolonomicController
from sim_nodes.navigation.hybrid import HybridPlanner
from sim_nodes.navigation.planner import GridPlanner
from sim_nodes.navigation.plugins import find_controller, find_planner
from sim_nodes.navigation.pursuit import PursuitController
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.kinematics import Velocity
from tests.installed_packages import add_entry_points
from tests.sim_nodes import robots_of_makers as makers
from tests.sim_nodes.client import Client, pose

HERE = __name__


class DetourPlanner(Planner):
    """Paths over a point beside the start."""

    made: ClassVar[list[Setup]] = []

    def __init__(self, setup: Setup) -> None:
        unknown = setup.parameters.keys() - {"aside"}
        if unknown:
            raise InvalidParameter(f"unknown parameter `{min(unknown)}`; expected `aside`")
        self._aside = setup.parameters["aside"]
        self.made.append(setup)

    def plan(self, request: PlanRequest) -> Path | None:
        start, goal = request.start, request.goal
        assert isinstance(self._aside, float)
        corners = [start[:2], (start.x, start.y + self._aside), goal[:2]]
        return Path(np.vstack([np.linspace(a, b, 20) for a, b in pairwise(corners)]))


NOT_A_PLANNER = Velocity(0.0, 0.0)


def client_with(folder: File, navigation: str) -> Client:
    more = f"mobile: {{navigation: {{{navigation}}}}}\n"
    return Client(makers.write_robot(folder, makers.two_wheels(), "differential", more))


def test_a_robot_arrives_along_the_paths_of_its_own_planner(tmp_path: File) -> None:
    plugin = f'planner: {{plugin: "{HERE}:DetourPlanner", parameters: {{aside: 1}}}}'
    DetourPlanner.made.clear()
    client = client_with(tmp_path, plugin)
    [setup] = DetourPlanner.made
    assert setup.parameters == {"aside": 1.0}
    client.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="mine", pose=pose(1.0, 0.0)))
    request = wire.NavigateThroughPoses(id="goal", robot="mine", poses=(pose(-1.0, 0.0),), stop_at_each=True)
    client.ask(wire.NAVIGATE_THROUGH_POSES, request)
    client.advance(4.0)
    assert client.simulator.simulation.frames.true_pose("mine").y > 0.4
    ended, _ = client.run_until("goal")
    assert ended.outcome is Outcome.SUCCEEDED
    there = client.simulator.simulation.frames.true_pose("mine")
    assert there.distance(-1.0, 0.0) < 0.2


@pytest.mark.parametrize(
    ("navigation", "words"),
    [
        (
            "planner: {plugin: dijkstra}",
            r"robot mine: unknown planner 'dijkstra' \(known: grid.*expected one of them, an entry",
        ),
        ("controller: {plugin: dwb}", r"unknown controller 'dwb' \(known: arcs"),
        (f'planner: {{plugin: "{HERE}:Missing"}}', "cannot import the planner '.*:Missing': AttributeError"),
        ('planner: {plugin: "no_such_module:A"}', "ModuleNotFoundError: No module named 'no_such_module'"),
        ('planner: {plugin: "fails_at_import:A"}', "planner 'fails_at_import:A': RuntimeError: no licence"),
        (
            f'planner: {{plugin: "{HERE}:NOT_A_PLANNER"}}',
            "is not a planner; expected a class below sim_nodes.*Pla",
        ),
        (f'controller: {{plugin: "{HERE}:DetourPlanner"}}', "is not a controller; expected a class below sim_nod"),
        (
            f'planner: {{plugin: "{HERE}:DetourPlanner", parameters: {{speed: 1}}}}',
            "invalid parameters of the navigation plugin '.*:DetourPlanner': unknown parameter `speed`; exp",
        ),
        (
            "planner: {plugin: grid, parameters: {speed: 1}}",
            "unknown parameter `speed`; the planner `grid` has no",
        ),
    ],
)
def test_invalid_plugins_are_refused(
    navigation: str, words: str, tmp_path: File, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "fails_at_import.py").write_text('raise RuntimeError("no licence")\n')
    with pytest.raises(RequestRefused, match=words):
        client_with(tmp_path, navigation)


def test_plugins_are_found_by_entry_point(tmp_path: File, monkeypatch: pytest.MonkeyPatch) -> None:
    add_entry_points(
        tmp_path,
        "detours",
        f"[seoro.navigation.planners]\ndetour = {HERE}:DetourPlanner\n"
        f"[seoro.navigation.controllers]\nbroken = {HERE}:Missing\n",
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert find_planner("detour") is DetourPlanner
    with pytest.raises(RequestRefused, match=r"unknown planner 'other' \(known: detour, grid"):
        find_planner("other")
    with pytest.raises(RequestRefused, match="cannot import the controller 'broken': AttributeError"):
        find_controller("broken")


def test_own_planner_and_controller_fulfil_the_contract() -> None:
    check_planner(GridPlanner)
    check_controller(ArcController)


def with_drive(kind: DriveKind) -> MobileDeclaration:
    """Return the base of the rules with another drive."""
    declared = robot_with(kind).mobile
    assert declared is not None
    return BASE.model_copy(update={"drive": declared.drive})


CAR, PLATFORM = with_drive(DriveKind.ACKERMANN), with_drive(DriveKind.OMNIDIRECTIONAL)


@pytest.mark.parametrize("base", [BASE, CAR])
def test_the_controller_for_poses_fulfils_the_contract(base: MobileDeclaration) -> None:
    check_controller(PursuitController, base=base)


def test_the_controller_of_omnidirectional_robots_fulfils_the_contract() -> None:
    check_controller(HolonomicController, base=PLATFORM)


@pytest.mark.slow
@pytest.mark.parametrize("base", [BASE, CAR, PLATFORM])
def test_the_planner_for_poses_fulfils_the_contract(base: MobileDeclaration) -> None:
    check_planner(HybridPlanner, {"reverse_penalty": 3}, base)


def test_planners_and_controllers_that_ignore_a_turning_radius_are_found() -> None:
    with pytest.raises(AssertionError, match=r"bend no tighter than the car. But a path has no headings"):
        check_planner(Bending, base=CAR)
    with pytest.raises(AssertionError, match=r"is a curve tighter than 0.7 m"):
        check_controller(Spinning, base=CAR)


class Bending(GridPlanner):
    """It plans for a robot that turns in place."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(replace(setup, declaration=BASE))


class Straight(GridPlanner):
    """It ignores walls."""

    def plan(self, request: PlanRequest) -> Path | None:
        return Path(np.array([request.start[:2], request.goal[:2]]))


class Short(GridPlanner):
    """Its paths end before the goal."""

    def plan(self, request: PlanRequest) -> Path | None:
        path = super().plan(request)
        return None if path is None else Path(path.points[:-1])


class Optimistic(GridPlanner):
    """It finds paths to closed goals."""

    def plan(self, request: PlanRequest) -> Path | None:
        return super().plan(request) or Path(np.array([request.start[:2], request.goal[:2]]))


class Crab(GridPlanner):
    """It has headings across its steps."""

    def plan(self, request: PlanRequest) -> Path | None:
        path = super().plan(request)
        if path is None:
            return None
        yaw, end = request.start.yaw, request.goal.yaw
        return Path(path.points, np.append(np.full(len(path.points) - 1, yaw), end))


class Moody(GridPlanner):
    """It has random numbers of its own."""

    def plan(self, request: PlanRequest) -> Path | None:
        path = super().plan(request)
        if path is not None:
            path.points[1:-1] += random.uniform(-1e-3, 1e-3)
        return path


class Forgetful(GridPlanner):
    """It counts its plans, but not in `STATE`."""

    _count = 0

    def plan(self, request: PlanRequest) -> Path | None:
        path = super().plan(request)
        self._count += 1
        if path is not None:
            path.points[1:-1] += 1e-6 * self._count
        return path


@pytest.mark.parametrize(
    ("planner", "words"),
    [
        (Straight, "Paths keep the clearance from walls"),
        (Short, "the last point of a path"),
        (Optimistic, "a path leads through a wall"),
        (Crab, "aside of the heading; the robot cannot move sideways"),
        (Moody, "different paths for the same requests"),
        (Forgetful, "a restored planner returned other paths"),
    ],
)
def test_planners_that_break_a_rule_are_found(planner: type[Planner], words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_planner(planner)


class Reckless(ArcController):
    """It drives on where it should stop."""

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        return super().follow(path, now, stops=stops) or Velocity(0.1, 0.0)


class Racing(ArcController):
    """It is faster than the drive."""

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        found = super().follow(path, now, stops=stops)
        return None if found is None else Velocity(1.2 * found.linear, 1.2 * found.angular)


class Spinning(PursuitController):
    """It turns twice as much on its way."""

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        found = super().follow(path, now, stops=stops)
        return found and Velocity(found.linear / 2.0, found.angular)


class Dreaming(ArcController):
    """It counts its decisions, but not in `STATE`."""

    _count = 0

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        found = super().follow(path, now, stops=stops)
        self._count += 1
        return None if found is None else Velocity(found.linear, found.angular * (1.0 - 1e-6 * self._count))


@pytest.mark.parametrize(
    ("controller", "words"),
    [
        (Reckless, "the robot drives into them"),
        (Racing, "exceeds the limits of the drive"),
        (Dreaming, "a restored controller returned other velocities"),
    ],
)
def test_controllers_that_break_a_rule_are_found(controller: type[Controller], words: str) -> None:
    with pytest.raises(AssertionError, match=words):
        check_controller(controller)
