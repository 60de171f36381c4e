"""Loss of power of an arm."""

from __future__ import annotations

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Freeze, Outcome, PowerLoss
from sim_nodes.__main__ import ENGINES
from sim_nodes.manipulation.arm import Arm
from sim_nodes.refusal import RequestRefused
from tests.sim_nodes.manipulation.cell import ARM, Cell


def inject(cell: Cell, fault: wire.Fault, limit: float = 5.0) -> None:
    request = wire.InjectFault(id="fault", robot=ARM, device="joints", fault=fault, limit=limit)
    cell.ask(wire.INJECT_FAULT, request)


def positions(cell: Cell) -> list[float]:
    return list(cell.joints.positions[:6])


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_without_power_stands_where_it_is_until_it_has_some_again(engine: str) -> None:
    cell = Cell(engine)
    home = positions(cell)
    target = tuple(np.add(home, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist())
    cell.start_joints(target)
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=150))
    inject(cell, PowerLoss())
    ended: dict[str, wire.Occurrence] = {}
    while len(ended) < 2:
        ended |= {each.id: each for each in cell.advance(cell.now + 10.0).occurrences}
    assert ended["fault"].outcome is Outcome.SUCCEEDED, ended["fault"].message
    assert ended["move"].outcome is Outcome.ABORTED
    stands = positions(cell)
    assert 0.01 < stands[0] - home[0] < 1.9
    cell.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    np.testing.assert_allclose(positions(cell), stands, atol=0.01)
    cell.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ARM))
    cell.start_joints(target)
    assert cell.end("move").outcome is Outcome.SUCCEEDED


def test_that_an_arm_has_no_power_shows_when_it_is_to_move() -> None:
    cell = Cell()
    inject(cell, PowerLoss(), limit=0.5)
    found = cell.end("fault")
    assert found.outcome is Outcome.ABORTED
    assert "a joint was to move by 0.000 rad" in found.message


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_that_goes_on_with_power_is_found_out(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Arm, "power", lambda self, on: None)
    cell = Cell(engine)
    inject(cell, PowerLoss(), limit=4.0)
    cell.start_joints(tuple(np.add(positions(cell), [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()))
    ended: dict[str, wire.Occurrence] = {}
    while len(ended) < 2:
        ended |= {each.id: each for each in cell.advance(cell.now + 10.0).occurrences}
    assert (ended["move"].outcome, ended["fault"].outcome) == (Outcome.SUCCEEDED, Outcome.ABORTED)


def test_joints_cannot_freeze() -> None:
    with pytest.raises(RequestRefused, match="joints cannot have freeze: they can have power_loss"):
        inject(Cell(), Freeze())
