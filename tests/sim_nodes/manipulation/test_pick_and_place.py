"""Cubes anywhere on the table are picked, held and placed, by friction alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Array
from tests.sim_nodes.engines import PYBULLET_IN_MORE
from tests.sim_nodes.graph import differences
from tests.sim_nodes.manipulation.cell import ARM, Cell, down

ENGINES = ("mujoco", "pybullet")
LOWEST, HIGHEST = (0.45, -0.35, -math.pi / 4), (0.85, 0.35, math.pi / 4)  # x, y [m], yaw [rad]
GOAL = (0.5, -0.5)


def poses(count: int) -> Array:
    return np.random.default_rng(0).uniform(LOWEST, HIGHEST, size=(count, 3))


def pick_and_place(engine: str, x: float, y: float, yaw: float, holding: float) -> Cell:
    cell = Cell(engine)
    cell.place("cube", x, y, 0.025, yaw)
    cell.pick("cube", x, y, yaw)
    before = cell.where("cube")
    assert before[2] == pytest.approx(0.175, abs=5e-3)
    cell.ask(wire.HOLD_ENTITY, wire.HoldEntity(id="hold", robot=ARM, entity="cube", duration=holding))
    ended = cell.end("hold")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert cell.where("cube") == pytest.approx(before, abs=2e-3)
    cell.move(down(*GOAL, 0.18))
    cell.move(down(*GOAL, 0.03), straight=True)
    cell.grip(0.085)
    cell.move(down(*GOAL, 0.18), straight=True)
    placed = cell.where("cube")
    assert math.dist(placed[:2], GOAL) < 0.01
    assert placed[2] == pytest.approx(0.025, abs=1e-3)
    return cell


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("pose", poses(50)[:1].tolist())
def test_a_cube_is_picked_and_placed(engine: str, pose: tuple[float, float, float]) -> None:
    pick_and_place(engine, *pose, holding=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("pose", poses(50).tolist())
def test_fifty_of_fifty_cubes_are_picked_held_and_placed(engine: str, pose: tuple[float, float, float]) -> None:
    pick_and_place(engine, *pose, holding=10.0)


def test_a_repeated_run_is_bit_identical() -> None:
    first, second = (pick_and_place("mujoco", 0.7, -0.2, 0.3, holding=0.2) for _ in range(2))
    assert first.now == second.now
    assert first.joints == second.joints
    assert first.where("cube") == second.where("cube")


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_a_fork_during_a_pick_continues_as_the_original(engine: str) -> None:
    original = Cell(engine)
    original.place("cube", 0.7, -0.2, 0.025, 0.3)
    original.pick("cube", 0.7, -0.2, 0.3)
    original.start_tool(down(*GOAL, 0.18))
    original.ask(wire.HOLD_ENTITY, wire.HoldEntity(id="hold", robot=ARM, entity="cube", duration=1.0))
    watch = wire.WatchJoint(id="near", robot=ARM, joint="shoulder_pan_joint", position=-0.9, tolerance=0.05)
    original.ask(wire.WATCH_JOINT, watch)
    original.advance(original.now + 0.2)
    snapshot = original.ask(wire.SAVE_STATE, wire.Empty())
    fork = Cell(engine)
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    seen = [[(cell.end("near"), cell.end("hold"), cell.joints, cell.where("cube"))] for cell in (original, fork)]
    assert seen[0] == seen[1]
