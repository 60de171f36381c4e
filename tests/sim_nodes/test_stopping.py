"""Emergency stops of a simulator whose main thread is busy."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.leasing import Leasing
from sim_nodes.stopping import Stops
from tests.sim_nodes.client import ROBOT, Client

SMOKE = wire.EmergencyStop(by="ana", reason="smoke")
SETTLED = 5.0  # [s]


def test_no_time_passes_until_the_robots_stand_still(maze: Client, tmp_path: Path) -> None:
    woken: list[None] = []
    leasing = Leasing(maze.simulator, tmp_path / "stop.json")
    stops = Stops(maze.simulator, leasing, lambda: woken.append(None))
    maze.ask(wire.DRIVE, wire.Drive(id="g", robot=ROBOT, linear=0.2, angular=0.0, duration=60.0))
    maze.simulator.simulation.run(1.0)
    stopped = stops.stop(SMOKE)
    assert woken == [None]
    maze.simulator.simulation.run(2.0)
    assert maze.simulator.time == 1.0
    maze.simulator.simulation.step(1000)
    assert maze.simulator.time == 1.0
    assert stopped.result(SETTLED).stopped == (ROBOT,)  # which is said while the main thread is busy
    assert stops.settle()
    assert not stops.settle()
    maze.simulator.simulation.run(2.0)
    twist = maze.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=ROBOT)).twist
    assert abs(twist.linear.x) < 0.01
    with pytest.raises(RequestRefused, match=r"emergency stop by ana at .* \(smoke\)"):
        leasing.latch.check()


def test_the_main_thread_acknowledges_when_it_is_free(maze: Client) -> None:
    stops = Stops(maze.simulator, Leasing(maze.simulator), lambda: None)
    first, second = stops.stop(SMOKE), stops.stop(SMOKE)
    assert stops.settle()
    assert first.done()
    assert second.done()
