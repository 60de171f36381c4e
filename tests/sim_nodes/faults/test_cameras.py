"""Faults of cameras in a world."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from seoro.bridges import wire
from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadArea,
    DeadPixels,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    Outcome,
    Position3D,
    PowerLoss,
    Quantity,
    ResetScope,
    Result,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import cameras
from sim_nodes.__main__ import ENGINES
from sim_nodes.sensors import camera_pipeline as camera_feed
from sim_nodes.sensors.camera_pipeline import CameraPipeline, Missing
from sim_nodes.views import NoRendering, Picture
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import needs_pictures
from tests.sim_nodes.graph import differences
from tests.sim_nodes.test_snapshots import restore, save

EYE = "eye"
FRONT = f"{ROBOT}/front"
BRIGHTNESS = Quantity.BRIGHTNESS
NAN = float("nan")
FAULTS: tuple[Fault, ...] = (
    GaussianNoise(deviation={BRIGHTNESS: 0.05}),
    Bias(offset={BRIGHTNESS: 0.1}),
    DeadPixels(share=0.02),
    DeadArea(left=0.25, top=0.5, right=0.75, bottom=1.0),
    MessageLoss(probability=0.3),
    Freeze(),
    Delay(time=0.5),
    PowerLoss(),
)


def noise(deviation: float) -> GaussianNoise:
    return GaussianNoise(deviation={BRIGHTNESS: deviation})


def bias(offset: float) -> Bias:
    return Bias(offset={BRIGHTNESS: offset})


def scene(engine: str = "mujoco") -> Client:
    """A robot that drives past a small free camera."""
    needs_pictures(engine)
    client = Client("empty", engine=engine)
    place = pose(1.0, -1.5, z=0.6)
    client.ask(wire.SPAWN_CAMERA, wire.SpawnCamera(name=EYE, pose=place, fov=0.8, width=96, height=64))
    client.ask(wire.AIM_CAMERA, wire.AimCamera(name=EYE, target=Position3D(x=0.3, z=0.1)))
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.2, duration=60.0))
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=10))
    return client


def inject(
    client: Client, fault: Fault, device: str = EYE, robot: str = "", limit: float = 5.0, name: str = "fault"
) -> None:
    client.ask(wire.INJECT_FAULT, wire.InjectFault(id=name, robot=robot, device=device, fault=fault, limit=limit))


def clear(client: Client, device: str = "", kind: str = "", robot: str = "") -> None:
    client.ask(wire.CLEAR_FAULTS, wire.ClearFaults(robot=robot, device=device, kind=kind))


def image(client: Client, camera: str = EYE) -> wire.CameraImage:
    return client.ask(wire.GET_CAMERA_IMAGE, wire.EntityName(name=camera))


def picture(client: Client, camera: str = EYE) -> Picture:
    return np.asarray(Image.open(io.BytesIO(image(client, camera).data)))


def pipeline(client: Client, camera: str = EYE) -> CameraPipeline:
    return client.simulator.simulation.entities.cameras.pipeline(camera)


def pass_time(client: Client, duration: float) -> None:
    client.simulator.simulation.run(client.simulator.simulation.time + duration)


def confirmed(client: Client, name: str = "fault") -> str:
    ended, _ = client.run_until(name)
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    return ended.message


@pytest.mark.parametrize("engine", ENGINES)
def test_faults_are_found_by_the_pictures(engine: str) -> None:
    client = scene(engine)
    for fault in FAULTS:
        inject(client, fault)
        assert confirmed(client).startswith(f"{fault.kind} of eye takes effect: ")
        clear(client, EYE)


def test_images_have_faults_and_recordings_have_none() -> None:
    client = scene()
    sound = picture(client)
    inject(client, bias(0.2))
    inject(client, DeadArea(left=0.5, top=0.0, right=1.0, bottom=1.0), name="dead")
    confirmed(client)
    confirmed(client, "dead")
    assert (picture(client)[:, 48:] == 0).all()
    assert (picture(client)[:, :48] >= pipeline(client).true_picture()[:, :48]).all()
    assert pipeline(client).true_picture().mean() == pytest.approx(sound.mean(), rel=0.05)
    clear(client, EYE)
    np.testing.assert_array_equal(picture(client), pipeline(client).true_picture())


def test_a_delayed_camera_returns_old_images_with_their_times() -> None:
    client = scene()
    inject(client, Delay(time=0.5))
    with pytest.raises(RequestRefused, match="no image from 'eye': the image is delayed"):
        image(client)
    confirmed(client)
    then = {}
    for _ in range(8):
        then[round(client.simulator.simulation.time, 6)] = pipeline(client).true_picture()
        client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=25))
    given = image(client)
    assert 0.5 - 1e-6 <= client.simulator.simulation.time - given.time < 0.6
    pixels = np.asarray(Image.open(io.BytesIO(given.data)))
    np.testing.assert_array_equal(pixels, then[round(given.time, 6)])
    clear(client, EYE)
    assert image(client).time == client.simulator.simulation.time


def test_a_frozen_camera_repeats_the_image_of_the_freeze() -> None:
    client = scene()
    inject(client, Freeze())
    pass_time(client, 0.02)
    frozen = picture(client)
    np.testing.assert_array_equal(frozen, pipeline(client).true_picture())
    confirmed(client)
    pass_time(client, 1.0)
    np.testing.assert_array_equal(picture(client), frozen)
    assert image(client).time == client.simulator.simulation.time
    assert (pipeline(client).true_picture() != frozen).any()
    clear(client, EYE, "freeze")
    np.testing.assert_array_equal(picture(client), pipeline(client).true_picture())


def test_lost_images_are_refused_and_later_ones_arrive() -> None:
    client = scene()
    inject(client, MessageLoss(probability=0.5))
    confirmed(client)
    chances = []
    for _ in range(60):
        pass_time(client, 0.02)
        chances.append(pipeline(client).missing(client.simulator.simulation.tick))
    assert 15 < chances.count(Missing.LOST) < 45
    while pipeline(client).missing(client.simulator.simulation.tick) is None:
        pass_time(client, 0.02)
    with pytest.raises(RequestRefused, match="no image from 'eye': the image was lost") as refused:
        image(client)
    assert refused.value.code == Result.OPERATION_FAILED
    while pipeline(client).missing(client.simulator.simulation.tick) is Missing.LOST:
        pass_time(client, 0.02)
    assert image(client).width == 96


def test_a_camera_without_power_gives_no_image() -> None:
    client = scene()
    inject(client, PowerLoss())
    with pytest.raises(RequestRefused, match="no image from 'eye': the camera has no power"):
        image(client)
    assert "pictures in a row are missing, for 0.50 s" in confirmed(client)
    clear(client)
    assert image(client).width == 96


def test_cameras_of_robots_are_devices() -> None:
    client = scene()
    [robot] = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    assert "front" in robot.devices
    inject(client, noise(0.1), "front", ROBOT)
    assert "gaussian_noise of turtlebot4/front takes effect" in confirmed(client)
    clear(client)  # of free cameras only
    assert list(pipeline(client, FRONT).faults) == ["gaussian_noise"]
    clear(client, robot=ROBOT)
    assert pipeline(client, FRONT).faults == {}


def test_a_robot_without_power_gives_no_images() -> None:
    client = scene()
    inject(client, PowerLoss(), "robot", ROBOT)
    assert "front: " in confirmed(client)
    with pytest.raises(RequestRefused, match="the camera has no power"):
        image(client, FRONT)
    clear(client, robot=ROBOT)
    assert image(client, FRONT).width > 0


def test_a_fault_of_a_camera_that_is_deleted_ends_with_it() -> None:
    client = scene()
    inject(client, Delay(time=5.0), limit=100.0)
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name=EYE))
    snapshot = save(client)
    ended, _ = client.run_until("fault")
    assert (ended.outcome, ended.message) == (Outcome.ABORTED, "eye was deleted")
    fork = Client("empty", 99)
    restore(fork, snapshot)
    assert fork.run_until("fault")[0] == ended


def test_a_reset_clears_faults_and_ends_their_checks() -> None:
    client = scene()
    inject(client, Delay(time=5.0), limit=100.0)
    inject(client, Delay(time=5.0), "lidar", ROBOT, 100.0, "scans")
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.STATE))
    assert pipeline(client).faults == {}
    for name in ("fault", "scans"):
        client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id=name, robot=ROBOT, distance=1.0))  # the id is free
    ended = {each.id: each for each in client.advance(1.0).occurrences}
    assert {name: ended[name].outcome for name in ("fault", "scans")} == {
        "fault": Outcome.CANCELED,
        "scans": Outcome.CANCELED,
    }


def test_cancelling_the_check_clears_the_fault() -> None:
    client = scene()
    inject(client, Delay(time=5.0))
    with pytest.raises(RequestRefused, match="duplicate id 'fault'"):
        inject(client, Freeze())
    client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="fault"))
    assert client.run_until("fault")[0].outcome is Outcome.CANCELED
    assert pipeline(client).faults == {}


@pytest.mark.parametrize("engine", ["mujoco", pytest.param("pybullet", marks=pytest.mark.slow)])
def test_faults_of_cameras_are_in_snapshots(engine: str) -> None:
    client = scene(engine)
    inject(client, Delay(time=0.4), name="late")
    inject(client, MessageLoss(probability=0.1), "front", ROBOT, name="lost")
    inject(client, Freeze(), "front", ROBOT, name="frozen")
    pass_time(client, 0.33)
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name=client.spawn("box", pose(2.0, 2.0))))
    fork = Client("maze", 99, engine)
    restore(fork, save(client))
    assert differences(client.simulator.simulation, fork.simulator.simulation) == []
    for each in (client, fork):
        pass_time(each, 0.5)
    assert image(client).data == image(fork).data
    assert (pipeline(client, FRONT)._frozen, len(pipeline(fork)._in_transit)) == (pipeline(fork, FRONT)._frozen, 5)


def test_requesting_images_does_not_change_the_run() -> None:
    asked, unasked = scene(), scene()
    for client in (asked, unasked):
        inject(client, noise(0.1), name="noise")
        inject(client, Freeze())
        inject(client, MessageLoss(probability=0.3), name="loss")
    image(asked)
    for _ in range(3):
        pass_time(asked, 0.05)
        assert picture(asked, FRONT).size
        pass_time(unasked, 0.05)
    assert differences(asked.simulator.simulation, unasked.simulator.simulation) == []


def test_camera_faults_without_rendering_are_refused(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def blind(self: object, view: object) -> Picture:
        raise NoRendering("the lights are out")

    monkeypatch.setattr(type(empty.simulator.simulation.engine), "render", blind)
    with pytest.raises(RequestRefused, match="cannot render: the lights are out"):
        inject(empty, noise(0.1), "front", ROBOT)
    inject(empty, PowerLoss(), "robot", ROBOT)  # needs no rendering
    assert "front: " in confirmed(empty)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (GaussianNoise(deviation={}), "expected zero or more, and not all zero"),
        (GaussianNoise(deviation={Quantity.LENGTH: 0.1}), "gaussian_noise of length; quantities: brightness"),
        (noise(NAN), "finite number"),
        (noise(1e-5), "gaussian_noise of brightness by 1e-05 is lost by rounding; expected at least 0.0004"),
        (bias(0.001), "bias of brightness by 0.001 is lost by rounding; expected at least 0.002"),
        (bias(0.0), "invalid bias without an offset"),
        (DeadPixels(share=1.1), "invalid share 1.1"),
        (DeadPixels(share=1e-5), "invalid share 1e-05 of 6144 pixels"),
        (DeadArea(left=0.5, top=0.0, right=0.4, bottom=1.0), "invalid area from 0.5 to 0.4 across"),
        (DeadArea(left=NAN, top=0.0, right=0.4, bottom=1.0), "invalid area"),
        (DeadArea(left=0.5, top=0.0, right=0.502, bottom=1.0), "no pixel is from 0.5 to 0.502 across"),
        (Delay(time=11.0), "invalid delay of 11 s; expected 0.02 s to 10 s"),
        (MessageLoss(probability=0.0), "invalid probability 0"),
        (BeamLoss(share=0.5), "eye cannot have beam_loss: it has no beams"),
        (WheelSlip(left=0.5, right=0.5), "eye cannot have wheel_slip: it has no wheels"),
    ],
    ids=str,
)  # fmt: skip
def test_invalid_faults_are_refused(fault: Fault, message: str) -> None:
    client = scene()
    with pytest.raises(RequestRefused, match=message):
        inject(client, fault)
    assert client.simulator.simulation.camera_faults.goals == ()


def test_unknown_cameras_are_refused_with_the_known_ones() -> None:
    client = scene()
    with pytest.raises(RequestRefused, match="unknown free camera 'nose'; cameras: eye"):
        inject(client, Freeze(), "nose")
    with pytest.raises(RequestRefused, match=r"unknown device 'back' of turtlebot4; devices: .*front"):
        inject(client, Freeze(), "back", ROBOT)
    with pytest.raises(RequestRefused, match="lidar cannot have dead_pixels: it has no pixels"):
        inject(client, DeadPixels(share=0.1), "lidar", ROBOT)


def test_memory_for_kept_images_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    client = scene()
    monkeypatch.setattr(cameras, "MAX_KEPT", 260_000)  # 14 pictures of this size
    inject(client, Delay(time=1.0))
    inject(client, Delay(time=1.2), name="longer")  # in the place of the first
    with pytest.raises(
        RequestRefused, match=r"freeze of 'turtlebot4/front' keeps .* MB of images; .* 0 MB are left"
    ):
        inject(client, Freeze(), "front", ROBOT)
    pass_time(client, 2.0)
    assert len(pipeline(client)._in_transit) * camera_feed.PERIOD * 0.02 <= 1.2 + 0.2
