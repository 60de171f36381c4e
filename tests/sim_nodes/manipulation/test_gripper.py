from __future__ import annotations

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import pose
from tests.sim_nodes.manipulation.cell import ARM, Cell, box, down
from tests.sim_nodes.manipulation.test_arm import refused


@pytest.fixture
def cell() -> Cell:
    return Cell()


def hold(cell: Cell, entity: str = "", duration: float = 0.0) -> None:
    cell.ask(wire.HOLD_ENTITY, wire.HoldEntity(id="hold", robot=ARM, entity=entity, duration=duration))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_the_gripper_goes_to_an_opening_at_its_speed(engine: str) -> None:
    cell = Cell(engine)
    assert cell.state.opening == pytest.approx(0.085, abs=1e-3)
    start = cell.now
    cell.grip(0.03, max_velocity_scaling_factor=0.5)
    assert cell.now - start == pytest.approx(0.055 / 0.075, abs=0.25)
    assert cell.state.opening == pytest.approx(0.03, abs=1.5e-3)
    cell.grip(0.085)
    assert cell.state.opening == pytest.approx(0.085, abs=1.5e-3)
    assert cell.state.held == ""


def test_a_gripper_that_closes_without_an_object_holds_none(cell: Cell) -> None:
    cell.grip()
    assert cell.state.held == ""
    assert cell.state.opening == pytest.approx(0.0, abs=3e-3)
    assert "ur10e holds nothing, not 'cube'" in refused(hold, cell, "cube").message


@pytest.mark.parametrize(
    ("opening", "more", "words"),
    [
        (0.1, {}, "invalid opening 0.1 m; expected 0 to 0.085 m"),
        (-0.01, {}, "expected 0 to 0.085 m"),
        (float("nan"), {}, "expected finite numbers"),
        (0.0, {"force": 500.0}, "invalid force 500 N; expected 20 to 120 N"),
        (0.0, {"force": 1.0}, "expected 20 to 120 N"),
    ],
)
def test_impossible_goals_are_refused(cell: Cell, opening: float, more: dict[str, float], words: str) -> None:
    assert words in refused(cell.start_gripper, opening, **more).message


def test_a_second_goal_is_refused_while_the_gripper_is_busy(cell: Cell) -> None:
    cell.start_gripper(0.0)
    assert (
        "the gripper of ur10e is busy with goal 'grip'" in refused(cell.start_gripper, 0.05, goal="again").message
    )


@pytest.mark.parametrize("force", [20.0, 120.0])
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_gripped_bodies_stay_held_at_low_and_high_force(engine: str, force: float) -> None:
    cell = Cell(engine)
    cell.place("cube", 0.65, 0.1, 0.025)
    cell.pick("cube", 0.65, 0.1, 0.0, force=force)
    before = cell.where("cube")
    assert before[2] == pytest.approx(0.175, abs=5e-3)
    hold(cell, "cube", 1.0)
    assert cell.end("hold").outcome is Outcome.SUCCEEDED
    assert cell.where("cube") == pytest.approx(before, abs=2e-3)
    cell.grip(force=force)
    assert cell.state.held == "cube", "closing once more drops it"
    cell.grip(0.085)
    cell.advance(cell.now + 0.5)
    assert (cell.state.held, cell.where("cube")[2] < 0.05) == ("", True)


def test_loss_of_a_held_body_is_reported_immediately(cell: Cell) -> None:
    cell.place("cube", 0.65, 0.1, 0.025)
    cell.pick("cube", 0.65, 0.1, 0.0)
    assert "ur10e holds 'cube', not 'box'" in refused(hold, cell, "box").message
    hold(cell, duration=10.0)
    cell.advance(cell.now + 1.0)
    cell.ask(wire.DELETE_ENTITY, wire.EntityName(name="cube"))
    start = cell.now
    ended = cell.end("hold")
    assert (ended.outcome, ended.message) == (Outcome.ABORTED, "ur10e has lost 'cube'")
    assert cell.now - start < 0.3
    assert cell.state.held == ""


def test_paths_with_a_held_body_avoid_collisions(cell: Cell) -> None:
    cell.place("cube", 0.65, 0.1, 0.025)
    cell.pick("cube", 0.65, 0.1, 0.0)
    message = refused(cell.start_tool, down(0.65, -0.2, 0.015), straight=True).message
    assert "'cube', which it holds, with 'table'" in message
    cell.spawn("wall", pose(0.65, -0.1, z=0.7 + 0.075), box(0.3, 0.02, 0.13, static=True))
    message = refused(cell.start_tool, down(0.65, -0.3, 0.15), straight=True).message
    assert "'cube', which it holds, with 'wall'" in message
    cell.move(down(0.65, 0.2, 0.03))


def test_static_bodies_are_not_held(cell: Cell) -> None:
    cell.spawn("block", pose(0.65, 0.1, z=0.7 + 0.03), box(0.05, 0.05, 0.05, static=True))
    cell.move(down(0.65, 0.1, 0.18))
    cell.move(down(0.65, 0.1, 0.03), straight=True)
    cell.grip()
    assert cell.state.held == ""
    assert cell.state.opening == pytest.approx(0.05, abs=3e-3)


def test_fingers_that_are_kept_from_opening_fail(cell: Cell) -> None:
    cell.grip(0.03)
    cell.move(down(0.65, 0.1, 0.03))
    for side in (-1, 1):
        x = 0.65 + side * 0.06
        cell.spawn(f"block{side + 1}", pose(x, 0.1, z=0.7 + 0.03), box(0.04, 0.04, 0.05, static=True))
    cell.start_gripper(0.085)
    ended = cell.end("grip")
    assert ended.outcome is Outcome.ABORTED
    assert "the fingers of ur10e were stopped at 0.0" in ended.message


def test_a_canceled_gripper_stays_where_it_is(cell: Cell) -> None:
    cell.start_gripper(0.0)
    cell.advance(0.2)
    cell.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="grip"))
    cell.advance(cell.now + 0.5)
    opening = cell.state.opening
    assert 0.04 < opening < 0.075
    with pytest.raises(RequestRefused, match="no active goal 'grip'"):
        cell.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="grip"))


@pytest.mark.more
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize(("mass", "held"), [(3.0, True), (6.0, False)])
def test_heavy_bodies_slip_out_of_the_gripper(engine: str, mass: float, held: bool) -> None:
    cell = Cell(engine)
    heavy = box(0.05, 0.05, 0.05).replace("<mass>0.2<", f"<mass>{mass}<")
    cell.spawn("heavy", pose(0.65, 0.1, z=0.725), heavy)
    cell.move(down(0.65, 0.1, 0.18))
    cell.move(down(0.65, 0.1, 0.03), straight=True)
    cell.grip(force=25.0)  # friction bears up to 5.1 kg, with a coefficient of 1
    cell.start_tool(down(0.65, 0.1, 0.18), straight=True, max_velocity_scaling_factor=0.2)
    cell.end()
    cell.advance(cell.now + 1.0)
    assert (cell.where("heavy")[2] > 0.1) is held
