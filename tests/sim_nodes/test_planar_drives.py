"""Planar drives in engines: saved and rewound states continue identically."""

from __future__ import annotations

import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import ROBOT, run
from sim_nodes.check.drives import PLANAR, built_drive, command
from sim_nodes.physics import Engine, Rewinds, SavesState
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.kinematics import Velocity
from tests.sim_nodes.engines import make_engine

CURVE = Velocity(0.4, 0.3)


def continued(engine: Engine) -> list[object]:
    run(engine, 0.4)
    return [engine.body_state(ROBOT), engine.wheel_angles(ROBOT)]


@pytest.mark.parametrize("kind", PLANAR)
@pytest.mark.parametrize("engine", ENGINES)
def test_saved_and_rewound_drives_continue_identically(engine: str, kind: DriveKind) -> None:
    first = built_drive(lambda: make_engine(engine), kind)
    command(first, kind, CURVE, 0.5)
    assert isinstance(first, SavesState) and isinstance(first, Rewinds)
    saved, checkpoint = first.save(), first.checkpoint()
    expected = continued(first)
    other = built_drive(lambda: make_engine(engine), kind)
    assert isinstance(other, SavesState)
    other.restore(saved)
    assert continued(other) == expected
    assert checkpoint is not None
    first.rewind(checkpoint)
    assert continued(first) == expected
