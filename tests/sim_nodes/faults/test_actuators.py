"""Loss of power of an arm and its gripper."""

from __future__ import annotations

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import (
    Bias,
    Delay,
    Freeze,
    GaussianNoise,
    MessageLoss,
    Outcome,
    PowerLoss,
    Quantity,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.manipulation.gripper import Gripper
from sim_nodes.manipulation.servos import Servos
from tests.sim_nodes.graph import differences
from tests.sim_nodes.manipulation.cell import ARM, Cell, down
from tests.sim_nodes.test_snapshots import restore, save


def inject(cell: Cell, fault: wire.Fault, limit: float = 5.0, device: str = "joints") -> None:
    request = wire.InjectFault(id="fault", robot=ARM, device=device, fault=fault, limit=limit)
    cell.ask(wire.INJECT_FAULT, request)


def both_end(cell: Cell) -> dict[str, wire.Occurrence]:
    """Return the results of the check of the fault and of the goal of the arm."""
    ended: dict[str, wire.Occurrence] = {}
    while len(ended) < 2:
        ended |= {each.id: each for each in cell.advance(cell.now + 10.0).occurrences}
    return ended


def positions(cell: Cell) -> list[float]:
    return list(cell.joints.positions[:6])


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_without_power_stands_still_until_power_returns(engine: str) -> None:
    cell = Cell(engine)
    home = positions(cell)
    target = tuple(np.add(home, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist())
    cell.start_joints(target)
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=150))
    inject(cell, PowerLoss())
    ended = both_end(cell)
    assert ended["fault"].outcome is Outcome.SUCCEEDED, ended["fault"].message
    assert ended["move"].outcome is Outcome.ABORTED
    stands = positions(cell)
    assert 0.01 < stands[0] - home[0] < 1.9
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    np.testing.assert_allclose(positions(cell), stands, atol=0.01)
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.start_joints(target)
    assert cell.end("move").outcome is Outcome.SUCCEEDED


def test_power_loss_of_an_arm_is_confirmed_when_it_is_commanded_to_move() -> None:
    cell = Cell()
    inject(cell, PowerLoss(), limit=0.5)
    found = cell.end("fault")
    assert found.outcome is Outcome.ABORTED
    assert "a joint was commanded to move by 0.000 rad" in found.message


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_that_keeps_moving_does_not_confirm_power_loss(
    engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Servos, "set_power", lambda self, on: None)
    cell = Cell(engine)
    inject(cell, PowerLoss(), limit=4.0)
    cell.start_joints(tuple(np.add(positions(cell), [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()))
    ended = both_end(cell)
    assert (ended["move"].outcome, ended["fault"].outcome) == (Outcome.SUCCEEDED, Outcome.ABORTED)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("scaling", [1.0, 0.02])
def test_a_gripper_without_power_does_not_move(engine: str, scaling: float) -> None:
    cell = Cell(engine)
    cell.grip(0.06)
    inject(cell, PowerLoss(), device="gripper")
    cell.start_gripper(0.02, max_velocity_scaling_factor=scaling)
    ended = both_end(cell)
    assert ended["fault"].outcome is Outcome.SUCCEEDED, ended["fault"].message
    assert "a finger was commanded to move by 0." in ended["fault"].message
    assert ended["grip"].outcome is Outcome.ABORTED
    assert ended["grip"].message == "the fingers of ur10e were stopped at 0.060 m"
    assert cell.state.opening == pytest.approx(0.06, abs=1.5e-3)
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.grip(0.02)
    assert cell.state.opening == pytest.approx(0.02, abs=1.5e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_fingers_stop_when_they_lose_power(engine: str) -> None:
    cell = Cell(engine)
    cell.start_gripper(0.0, max_velocity_scaling_factor=0.3)
    cell.advance(0.8)
    inject(cell, PowerLoss(), device="gripper")
    ended = both_end(cell)
    assert {name: each.outcome for name, each in ended.items()} == {
        "fault": Outcome.SUCCEEDED,
        "grip": Outcome.ABORTED,
    }
    assert 0.03 < cell.state.opening < 0.07


@pytest.mark.parametrize("engine", ENGINES)
def test_a_gripped_body_stays_held_without_power(engine: str) -> None:
    cell = Cell(engine)
    cell.place("cube", 0.6, 0.1, 0.025)
    cell.pick("cube", 0.6, 0.1, 0.0)
    inject(cell, PowerLoss(), device="gripper")
    cell.start_gripper(0.085)
    assert both_end(cell)["fault"].outcome is Outcome.SUCCEEDED
    cell.move(down(0.6, -0.1, 0.25))
    assert (cell.state.held, cell.where("cube")[2] > 0.15) == ("cube", True)
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.grip(0.085)
    assert cell.state.held == ""


def test_blocked_fingers_do_not_confirm_power_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Gripper, "set_power", lambda self, on: None)
    cell = Cell()
    cell.place("cube", 0.6, 0.1, 0.025)
    cell.move(down(0.6, 0.1, 0.03))
    inject(cell, PowerLoss(), device="gripper", limit=2.0)
    cell.start_gripper(0.0)
    ended = both_end(cell)
    assert (ended["grip"].outcome, ended["fault"].outcome) == (Outcome.SUCCEEDED, Outcome.ABORTED)
    cell.grip(0.085)
    inject(cell, PowerLoss(), device="gripper", limit=2.0)
    cell.start_gripper(0.06, max_velocity_scaling_factor=0.02)
    ended = both_end(cell)
    assert (ended["grip"].outcome, ended["fault"].outcome) == (Outcome.SUCCEEDED, Outcome.ABORTED)


def test_power_loss_of_an_arm_stops_all_its_devices() -> None:
    cell = Cell()
    cell.start_joints(tuple(np.add(positions(cell), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()))
    cell.start_gripper(0.0)
    inject(cell, PowerLoss(), device="robot")
    ended = cell.end("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    for words in ("wrist: ", "the joints have been at rest", "the fingers have been at rest"):
        assert words in ended.message
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.grip(0.02)


WAYS: tuple[tuple[str, wire.Fault], ...] = (
    ("joints", GaussianNoise(deviation={Quantity.ANGLE: 0.002})),
    ("joints", Bias(offset={Quantity.ANGLE: 0.02})),
    ("joints", MessageLoss(probability=0.3)),
    ("joints", Freeze()),
    ("joints", Delay(time=0.04)),
    ("gripper", GaussianNoise(deviation={Quantity.LENGTH: 0.001})),
    ("gripper", Bias(offset={Quantity.LENGTH: 0.005})),
    ("gripper", MessageLoss(probability=0.3)),
    ("gripper", Freeze()),
    ("gripper", Delay(time=0.1)),
)


@pytest.mark.parametrize("engine", ENGINES)
def test_faults_change_commands_to_the_motors(engine: str) -> None:
    cell = Cell(engine)
    turn = 0.5
    for device, fault in WAYS:
        turn = -turn
        target = np.add(positions(cell), [turn, 0.0, 0.0, 0.0, 0.0, 0.0])
        cell.start_joints(tuple(target.tolist()), max_velocity_scaling_factor=0.3)
        cell.start_gripper(0.0 if cell.state.opening > 0.05 else 0.085, max_velocity_scaling_factor=0.2)
        inject(cell, fault, device=device)
        found = cell.end("fault")
        assert found.outcome is Outcome.SUCCEEDED, found.message
        assert f"{fault.kind} of ur10e/{device} takes effect" in found.message
        cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
        cell.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ARM))
        cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=150))


def test_faulty_commands_move_joints_and_fingers() -> None:
    cell = Cell()
    before = positions(cell)
    inject(cell, Bias(offset={Quantity.ANGLE: 0.03}))
    cell.end("fault")
    inject(cell, Bias(offset={Quantity.LENGTH: -0.02}), device="gripper")
    cell.end("fault")
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    np.testing.assert_allclose(np.subtract(positions(cell), before), 0.03, atol=3e-3)
    assert cell.state.opening == pytest.approx(0.065, abs=2e-3)
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    np.testing.assert_allclose(positions(cell), before, atol=3e-3)
    assert cell.state.opening == pytest.approx(0.085, abs=2e-3)


def test_frozen_joints_stop_the_motion_and_stay() -> None:
    cell = Cell()
    cell.start_joints(tuple(np.add(positions(cell), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()))
    cell.advance(0.6)
    inject(cell, Freeze())
    ended = both_end(cell)
    assert (ended["fault"].outcome, ended["move"].outcome) == (Outcome.SUCCEEDED, Outcome.ABORTED)
    assert "was blocked" in ended["move"].message
    stands = positions(cell)
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=500))
    np.testing.assert_allclose(positions(cell), stands, atol=0.02)


def test_faults_of_arms_are_in_snapshots() -> None:
    cell = Cell()
    cell.start_joints(tuple(np.add(positions(cell), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()))
    cell.start_gripper(0.0)
    cell.advance(0.2)
    inject(cell, Delay(time=0.06), limit=20.0)
    request = wire.InjectFault(id="slow", robot=ARM, device="gripper", fault=Delay(time=3.0), limit=20.0)
    cell.ask(wire.INJECT_FAULT, request)
    cell.advance(0.31)
    fork = Cell(seed=4)
    restore(fork, save(cell))
    assert differences(cell.simulator.simulation, fork.simulator.simulation) == []


@pytest.mark.parametrize(
    ("device", "fault", "words"),
    [
        (
            "joints",
            Bias(offset={Quantity.ANGLE: 0.6}),
            "bias of angle 0.6 is too large; expected at most 0.5",
        ),
        ("joints", Bias(offset={Quantity.LENGTH: 0.1}), "joints cannot have bias of length; quantities: angle"),
        ("gripper", WheelSlip(left=0.5, right=0.5), "gripper cannot have wheel_slip: it has no wheels"),
    ],
)
def test_invalid_faults_are_refused(device: str, fault: wire.Fault, words: str) -> None:
    with pytest.raises(RequestRefused, match=words):
        inject(Cell(), fault, device=device)
