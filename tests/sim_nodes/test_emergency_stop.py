"""Emergency stops of a simulator whose main thread is busy."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import verbs
from sim_nodes.leasing import EmergencyStops, Leasing
from tests.sim_nodes.client import ROBOT, Client

SMOKE = wire.EmergencyStop(by="ana", reason="smoke")
SETTLED = 5.0  # [s]


def test_time_is_held_until_the_robots_stand_still(maze: Client, tmp_path: Path) -> None:
    woken: list[None] = []
    leasing = Leasing(maze.simulator, tmp_path / "stop.json")
    stops = EmergencyStops(maze.simulator, leasing, lambda: woken.append(None))
    maze.ask(wire.DRIVE, wire.Drive(id="g", robot=ROBOT, linear=0.2, angular=0.0, duration=60.0))
    maze.simulator.simulation.run(1.0)
    stopped = stops.stop(SMOKE)
    assert woken == [None]
    passing: list[Callable[[], object]] = [
        lambda: maze.simulator.simulation.run(2.0),
        lambda: maze.simulator.simulation.step(1000),
    ]
    for pass_time in passing:
        pass_time()
        assert maze.simulator.time == 1.0
    assert stopped.result(SETTLED).stopped == (ROBOT,)  # acknowledged while the main thread is busy
    assert stops.apply_pending()
    assert not stops.apply_pending()
    maze.simulator.simulation.run(2.0)
    twist = maze.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=ROBOT)).twist
    assert abs(twist.linear.x) < 0.01
    with pytest.raises(RequestRefused, match=r"emergency stop by ana at .* \(smoke\)"):
        leasing.latch.check()


def test_the_main_thread_acknowledges_when_it_is_free(maze: Client) -> None:
    stops = EmergencyStops(maze.simulator, Leasing(maze.simulator), lambda: None)
    first, second = stops.stop(SMOKE), stops.stop(SMOKE)
    assert stops.apply_pending()
    assert first.done()
    assert second.done()


OTHER = "second"


class Shared:
    """A simulator with two robots, each leased by its own run."""

    def __init__(self, engine: str) -> None:
        self.client = Client("hall", engine=engine)
        self.simulator = self.client.simulator
        self.simulator.set_state(wire.SimulationState.PLAYING)
        self.leasing = Leasing(self.simulator)
        self.stops = EmergencyStops(self.simulator, self.leasing, lambda: None)
        for robot in (ROBOT, OTHER):
            self.carry(wire.TAKE_ROBOTS, wire.Holder(holder=robot, robots=(robot,)))

    def carry(self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.Message:
        """Execute a verb of leases."""
        reply: wire.Message = getattr(self.leasing, verb.name)(request)
        return reply

    def ask(self, sender: str, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> None:
        permit = partial(self.leasing.authorize, sender)
        verbs.handle(self.simulator, verb.name, wire.encode(request), permit)

    def drive(self, sender: str, robot: str) -> None:
        drive = wire.Drive(id=f"{sender}.{robot}", robot=robot, linear=0.2, angular=0.0, duration=60.0)
        self.ask(sender, wire.DRIVE, drive)

    def stop(self, *robots: str) -> wire.StopAcknowledgement:
        stopped = self.stops.stop(wire.EmergencyStop(by="ana", reason="smoke", robots=robots))
        self.stops.apply_pending()
        return stopped.result(SETTLED)

    def pass_time(self, seconds: float) -> None:
        self.simulator.simulation.run(self.simulator.time + seconds)

    def speed(self, robot: str) -> float:
        linear = self.client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=robot)).twist.linear
        return math.hypot(linear.x, linear.y)


@pytest.fixture(params=["mujoco", "pybullet"])
def shared(request: pytest.FixtureRequest) -> Shared:
    return Shared(request.param)


DOES_NOT_MOVE = f"the robot '{ROBOT}' may not move: emergency stop by ana"


def test_stopping_one_robot_leaves_the_other_moving(shared: Shared) -> None:
    for robot in (ROBOT, OTHER):
        shared.drive(robot, robot)
    shared.pass_time(1.0)
    assert shared.stop(ROBOT, "elsewhere").stopped == (ROBOT,)
    shared.pass_time(1.0)
    assert (shared.speed(ROBOT) < 0.01, shared.speed(OTHER) > 0.1) == (True, True)
    (ended,) = [each.occurrence for each in shared.simulator.log.since(0).events if each.occurrence]
    assert (ended.id, ended.interrupted) == (f"{ROBOT}.{ROBOT}", True)
    assert "emergency stop by ana" in ended.message
    with pytest.raises(RequestRefused, match=DOES_NOT_MOVE):
        shared.drive(ROBOT, ROBOT)
    with pytest.raises(RequestRefused, match=DOES_NOT_MOVE):
        shared.carry(wire.HOLD_ROBOTS, wire.HoldRobots(holder=ROBOT, since=0))
    shared.carry(wire.HOLD_ROBOTS, wire.HoldRobots(holder=OTHER, since=0))
    state = shared.carry(wire.GET_LAB_STATE, wire.Empty())
    assert isinstance(state, wire.LabState)
    assert [each.name for each in state.robots if each.stopped is not None] == [ROBOT]
    shared.carry(wire.RELEASE_STOP, wire.ReleaseStop(by="bob", reason="toast", robots=(ROBOT,)))
    shared.drive(ROBOT, ROBOT)


def test_a_stopped_robot_cannot_be_moved(shared: Shared) -> None:
    shared.carry(wire.RELEASE_ROBOTS, wire.Holder(holder=OTHER))
    shared.carry(wire.RELEASE_ROBOTS, wire.Holder(holder=ROBOT))
    shared.stop(ROBOT)
    stopped = wire.SetSimulationState(state=wire.SimulationState.STOPPED)
    paused = wire.SetSimulationState(state=wire.SimulationState.PAUSED)
    with pytest.raises(RequestRefused, match=DOES_NOT_MOVE):
        shared.ask("", wire.SET_SIMULATION_STATE, stopped)
    with pytest.raises(RequestRefused, match=DOES_NOT_MOVE):
        shared.ask("", wire.RESET_SIMULATION, wire.ResetSimulation())
    shared.ask("", wire.SET_SIMULATION_STATE, paused)
    shared.ask("", wire.STEP_SIMULATION, wire.StepSimulation(steps=1))
    with pytest.raises(RequestRefused, match=DOES_NOT_MOVE):
        shared.carry(wire.TAKE_ROBOTS, wire.Holder(holder="all of it"))


def test_an_unknown_robot_stops_nothing(shared: Shared) -> None:
    with pytest.raises(RequestRefused, match="unknown robots: elsewhere"):
        shared.stop("elsewhere")
    shared.drive(ROBOT, ROBOT)
    shared.pass_time(1.0)
    assert shared.speed(ROBOT) > 0.1
