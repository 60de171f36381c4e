"""Faults of a robot in a world."""

from __future__ import annotations

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
    DeadPixels,
    DeadSector,
    Delay,
    Fault,
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
from sim_nodes.faults.actuators import Actuator
from sim_nodes.sensors.sensor_pipeline import SensorPipeline
from tests.sim_nodes.client import ROBOT, Client

NOISE = GaussianNoise(deviation={Quantity.LENGTH: 0.3})
NAN = float("nan")


def noise_of_motors(deviation: float) -> GaussianNoise:
    return GaussianNoise(deviation={Quantity.ANGULAR_RATE: deviation})


def inject(client: Client, fault: Fault, device: str = "lidar", limit: float = 5.0, name: str = "fault") -> None:
    request = wire.InjectFault(id=name, robot=ROBOT, device=device, fault=fault, limit=limit)
    client.ask(wire.INJECT_FAULT, request)


def clear(client: Client, device: str = "", kind: str = "") -> None:
    client.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=ROBOT, device=device, kind=kind))


def test_devices_of_a_robot_are_listed(maze: Client) -> None:
    [robot] = maze.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    assert {"lidar", "odometry"} <= set(robot.devices)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_fault_is_reported_with_its_measurement(engine: str) -> None:
    client = Client(engine=engine)
    inject(client, NOISE)
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED
    assert ended.time == pytest.approx(0.1)
    assert "gaussian_noise of turtlebot4/lidar takes effect" in ended.message
    assert "values of length have a standard deviation of 0." in ended.message


def test_a_fault_without_an_effect_is_cleared_at_its_limit(empty: Client) -> None:
    inject(empty, NOISE, limit=1.0)  # the effect is not visible
    ended, _ = empty.run_until("fault")
    assert ended.outcome is Outcome.ABORTED
    assert ended.time == pytest.approx(1.0)
    assert ended.message == (
        "no effect of gaussian_noise of turtlebot4/lidar was confirmed: no comparable value of length has arrived"
    )
    assert empty.simulator.simulation.robot(ROBOT).mobile.sensors["lidar"].faults == {}


def test_clients_of_scans_receive_the_faulty_ones(maze: Client) -> None:
    maze.localise()
    base = maze.simulator.simulation.robot(ROBOT).mobile
    inject(maze, DeadSector(start=-3.0, end=3.0))
    maze.run_until("fault")
    latest = base.sensors["lidar"].latest
    assert latest is not None
    assert latest.data.hit.sum() < 20
    assert base._scan is latest.data


def test_another_fault_of_the_same_kind_replaces_the_first(maze: Client) -> None:
    inject(maze, Delay(time=0.5), name="first")
    inject(maze, Delay(time=0.1), name="second")
    first, _ = maze.run_until("first")
    assert (first.outcome, first.message) == (Outcome.CANCELED, "replaced by another fault of its kind")
    second, _ = maze.run_until("second")
    assert "the last of the samples was 0.1 s old" in second.message


def test_clearing_a_fault_ends_its_check(maze: Client) -> None:
    pipeline = maze.simulator.simulation.robot(ROBOT).mobile.sensors["lidar"]
    inject(maze, Freeze(), name="freeze")
    inject(maze, MessageLoss(probability=0.5), name="loss")
    clear(maze, "lidar", "freeze")
    assert list(pipeline.faults) == ["message_loss"]
    ended, _ = maze.run_until("freeze")
    assert (ended.outcome, ended.message) == (Outcome.CANCELED, "it was cleared")
    clear(maze)
    assert pipeline.faults == {}
    clear(maze)  # of nothing


def test_cancelling_the_check_clears_the_fault(maze: Client) -> None:
    inject(maze, NOISE)
    maze.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="fault"))
    ended, _ = maze.run_until("fault")
    assert ended.outcome is Outcome.CANCELED
    assert maze.simulator.simulation.robot(ROBOT).mobile.sensors["lidar"].faults == {}


def test_stopping_the_robot_leaves_its_faults(maze: Client) -> None:
    inject(maze, NOISE)
    maze.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ROBOT))
    assert maze.run_until("fault")[0].outcome is Outcome.SUCCEEDED


def test_a_reset_clears_faults(maze: Client) -> None:
    inject(maze, NOISE, limit=100.0)
    maze.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    assert maze.simulator.simulation.robot(ROBOT).mobile.sensors["lidar"].faults == {}


def test_faults_do_not_change_random_numbers_of_others(maze: Client) -> None:
    odometers = []
    for faulty in (False, True):
        client = Client()
        client.localise()
        if faulty:
            inject(client, BeamLoss(share=0.1))
        client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=100))
        odometers.append(client.simulator.simulation.robot(ROBOT).mobile.odometry)
    assert odometers[0] == odometers[1]


def driven(engine: str = "mujoco", linear: float = 0.25, angular: float = 0.0) -> Client:
    """Return a client of a robot that drives with a velocity for a long time."""
    client = Client("empty", engine=engine)
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=linear, angular=angular, duration=100.0))
    return client


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("left", "right", "linear", "angular"), [(0.5, 0.5, 0.25, 0.0), (1.0, 0.0, 0.25, 0.0), (0.2, 0.2, -0.2, 0.3)]
)
def test_wheels_slip_by_their_shares(
    left: float, right: float, linear: float, angular: float, engine: str
) -> None:
    client = driven(engine, linear, angular)
    inject(client, WheelSlip(left=left, right=right), "motors")
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert "by odometry and moved" in ended.message


def test_odometry_counts_slip_although_the_robot_barely_moves() -> None:
    client = driven()
    inject(client, WheelSlip(left=0.5, right=0.5), "motors")
    client.run_until("fault")
    for _ in range(5):
        client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    counted = client.simulator.simulation.robot(ROBOT).mobile.odometry.travelled
    assert client.truth.x == pytest.approx(counted / 2, rel=0.05)
    clear(client, "motors")
    before = client.truth.x
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=500))
    assert client.truth.x - before == pytest.approx(0.5, rel=0.05)


def test_slip_of_a_standing_robot_is_not_confirmed(empty: Client) -> None:
    inject(empty, WheelSlip(left=0.5, right=0.5), "motors", limit=1.0)
    ended, _ = empty.run_until("fault")
    assert ended.outcome is Outcome.ABORTED
    assert ended.message.endswith("by odometry the wheels have turned 0.00 and 0.00 m")


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_with_unpowered_motors_stands_still(engine: str) -> None:
    client = driven(engine)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    inject(client, PowerLoss(), "motors")
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    clear(client, "motors")
    before = client.truth.x
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    assert client.truth.x > before + 0.2


def test_power_loss_of_motors_is_confirmed_when_they_are_commanded(empty: Client) -> None:
    inject(empty, PowerLoss(), "motors", limit=5.0)
    empty.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    empty.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=9.0))
    assert empty.run_until("fault")[0].time == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_that_loses_its_power_in_a_curve_comes_to_rest(engine: str) -> None:
    client = driven(engine, 0.15, 0.209)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=100))
    inject(client, PowerLoss(), "robot")
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_without_power_sends_no_samples_and_stands_still(engine: str) -> None:
    client = driven(engine)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    base = client.simulator.simulation.robot(ROBOT).mobile
    inject(client, PowerLoss(), "lidar", name="own")
    inject(client, PowerLoss(), "robot")
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert "lidar: " in ended.message
    assert "the wheels have been at rest" in ended.message
    clear(client, "robot")
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    assert base.odometry.velocity.linear == pytest.approx(0.25, rel=0.1)
    assert base.sensors["lidar"].latest is None  # it is still without power of its own


MOTOR_FAULTS: tuple[Fault, ...] = (
    noise_of_motors(0.5),
    Bias(offset={Quantity.ANGULAR_RATE: -0.3}),
    MessageLoss(probability=0.5),
    Freeze(),
    Delay(time=0.3),
)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("fault", MOTOR_FAULTS, ids=str)
def test_faults_change_commands_to_the_motors(fault: Fault, engine: str) -> None:
    client = driven(engine)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=10))  # it is about to speed up
    inject(client, fault, "motors")
    ended, _ = client.run_until("fault")
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert f"{fault.kind} of turtlebot4/motors takes effect" in ended.message
    wheels = client.simulator.simulation.robot(ROBOT).mobile.wheels
    clear(client, "motors")
    assert wheels.applied == wheels.command


@pytest.mark.parametrize("fault", MOTOR_FAULTS, ids=str)
def test_sound_motors_do_not_confirm_a_command_fault(fault: Fault, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SensorPipeline, "add_fault", lambda self, fault: None)
    monkeypatch.setattr(Actuator, "is_busy", True)
    client = driven()
    inject(client, fault, "motors", limit=2.0)
    assert client.run_until("fault")[0].outcome is Outcome.ABORTED


def test_frozen_motors_keep_moving_and_delayed_ones_start_late() -> None:
    client = driven()
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=100))
    inject(client, Freeze(), "motors")
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=10))
    client.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ROBOT))
    before = client.truth.x
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=500))
    assert client.truth.x - before == pytest.approx(0.5, rel=0.1)
    clear(client, "motors", "freeze")
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    before = client.truth.x
    inject(client, Delay(time=1.0), "motors")
    client.ask(wire.DRIVE, wire.Drive(id="again", robot=ROBOT, linear=0.25, angular=0.0, duration=9.0))
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=240))
    assert client.truth.x == pytest.approx(before, abs=0.01)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    assert client.truth.x > before + 0.03


@pytest.mark.parametrize(("left", "right"), [(0.0, 0.0), (0.05, 0.5), (1.2, 0.0), (-0.3, 0.0), (NAN, 0.3)])
def test_invalid_slips_are_refused(left: float, right: float, maze: Client) -> None:
    with pytest.raises(RequestRefused, match=r"expected 0, or from 0\.1"):
        inject(maze, WheelSlip(left=left, right=right), "motors")


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (GaussianNoise(deviation={}), "expected zero or more, and not all zero"),
        (GaussianNoise(deviation={Quantity.LENGTH: -1.0}), "length -1"),
        (GaussianNoise(deviation={Quantity.LENGTH: NAN}), "finite number"),
        (GaussianNoise(deviation={Quantity.ACCELERATION: 1.0}), "of acceleration; quantities: length"),
        (Bias(offset={Quantity.LENGTH: 0.0}), "invalid bias without an offset"),
        (BeamLoss(share=1.5), "invalid share 1.5; expected more than 0, and at most 1"),
        (BeamLoss(share=NAN), "invalid share nan"),
        (BeamLoss(share=0.002), "invalid share 0.002 of 360 beams"),
        (DeadSector(start=NAN, end=0.0), "finite bearings"),
        (DeadSector(start=0.003, end=0.004), "no beam is between"),
        (DeadBeams(beams=(360,)), r"invalid dead beams \[360\]; expected one or more from 0 to 359"),
        (DeadBeams(beams=()), "one or more from 0"),
        (MessageLoss(probability=0.0), "invalid probability 0"),
        (Delay(time=11.0), "invalid delay of 11 s; expected 0.02 s to 10 s"),
    ],
    ids=str,
)
def test_invalid_faults_are_refused(fault: Fault, message: str, maze: Client) -> None:
    with pytest.raises(RequestRefused, match=message):
        inject(maze, fault)
    assert maze.simulator.simulation.robot(ROBOT).faults.goals == ()


@pytest.mark.parametrize(
    ("fault", "device", "message"),
    [
        (
            Freeze(),
            "nose",
            "unknown device 'nose' of turtlebot4; devices: bumper, front, imu, lidar, motors, odometry, robot",
        ),
        (BeamLoss(share=0.5), "odometry", "odometry cannot have beam_loss: it has no beams"),
        (WheelSlip(left=0.5, right=0.5), "lidar", "lidar cannot have wheel_slip: it has no wheels"),
        (BeamLoss(share=0.5), "motors", "motors cannot have beam_loss: it has no beams"),
        (DeadPixels(share=0.5), "motors", "motors cannot have dead_pixels: it has no pixels"),
        (Bias(offset={Quantity.LENGTH: 0.5}), "motors", "bias of length; quantities: angular_rate"),
        (noise_of_motors(60.0), "motors", "angular_rate 60 is too large; expected at most 50"),
        (Freeze(), "robot", "robot cannot have freeze: it can have power_loss"),
    ],
)
def test_faults_of_devices_that_cannot_have_them_are_refused(
    fault: Fault, device: str, message: str, maze: Client
) -> None:
    with pytest.raises(RequestRefused, match=message):
        inject(maze, fault, device)


@pytest.mark.parametrize("limit", [0.0, -1.0, NAN, 4000.0])
def test_invalid_limits_are_refused(limit: float, maze: Client) -> None:
    with pytest.raises(RequestRefused, match="invalid limit"):
        inject(maze, NOISE, limit=limit)


def test_an_id_in_use_is_refused(maze: Client) -> None:
    inject(maze, NOISE)
    with pytest.raises(RequestRefused, match="duplicate id 'fault'"):
        inject(maze, Freeze())
