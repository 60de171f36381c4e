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
    PowerLoss,
    Quantity,
    ResetScope,
    Result,
    Vector3,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import cameras
from sim_nodes.__main__ import ENGINES
from sim_nodes.sensors import camera_feed
from sim_nodes.sensors.camera_feed import CameraFeed, Missing
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
    """A robot that drives past a small free camera that looks at it."""
    needs_pictures(engine)
    client = Client("empty", engine=engine)
    place = pose(1.0, -1.5, z=0.6)
    client.ask(wire.SPAWN_CAMERA, wire.SpawnCamera(name=EYE, pose=place, fov=0.8, width=96, height=64))
    client.ask(wire.AIM_CAMERA, wire.AimCamera(name=EYE, target=Vector3(x=0.3, z=0.1)))
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


def feed(client: Client, camera: str = EYE) -> CameraFeed:
    return client.simulator.simulation.entities.cameras.feed(camera)


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


def test_what_users_get_has_the_faults_and_what_films_see_has_not() -> None:
    client = scene()
    sound = picture(client)
    inject(client, bias(0.2))
    inject(client, DeadArea(left=0.5, top=0.0, right=1.0, bottom=1.0), name="dead")
    confirmed(client)
    confirmed(client, "dead")
    assert (picture(client)[:, 48:] == 0).all()
    assert (picture(client)[:, :48] >= feed(client).sound()[:, :48]).all()
    assert feed(client).sound().mean() == pytest.approx(sound.mean(), rel=0.05)
    clear(client, EYE)
    np.testing.assert_array_equal(picture(client), feed(client).sound())


def test_a_delayed_camera_shows_what_was_then_and_says_when() -> None:
    client = scene()
    inject(client, Delay(time=0.5))
    with pytest.raises(RequestRefused, match="no picture of 'eye' has come: it is still on its way"):
        image(client)
    confirmed(client)
    then = {}
    for _ in range(8):
        then[round(client.simulator.simulation.time, 6)] = feed(client).sound()
        client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=25))
    given = image(client)
    assert 0.5 - 1e-6 <= client.simulator.simulation.time - given.time < 0.6
    pixels = np.asarray(Image.open(io.BytesIO(given.data)))
    np.testing.assert_array_equal(pixels, then[round(given.time, 6)])
    clear(client, EYE)
    assert image(client).time == client.simulator.simulation.time


def test_a_frozen_camera_gives_the_picture_of_the_moment_of_freezing() -> None:
    client = scene()
    inject(client, Freeze())
    pass_time(client, 0.02)
    frozen = picture(client)
    np.testing.assert_array_equal(frozen, feed(client).sound())
    confirmed(client)
    pass_time(client, 1.0)
    np.testing.assert_array_equal(picture(client), frozen)
    assert image(client).time == client.simulator.simulation.time
    assert (feed(client).sound() != frozen).any()
    clear(client, EYE, "freeze")
    np.testing.assert_array_equal(picture(client), feed(client).sound())


def test_lost_pictures_are_told_and_the_next_may_come() -> None:
    client = scene()
    inject(client, MessageLoss(probability=0.5))
    confirmed(client)
    chances = []
    for _ in range(60):
        pass_time(client, 0.02)
        chances.append(feed(client).missing(client.simulator.simulation.tick))
    assert 15 < chances.count(Missing.LOST) < 45
    while feed(client).missing(client.simulator.simulation.tick) is None:
        pass_time(client, 0.02)
    with pytest.raises(RequestRefused, match="no picture of 'eye' has come: it was lost on its way") as refused:
        image(client)
    assert refused.value.code == Result.OPERATION_FAILED
    while feed(client).missing(client.simulator.simulation.tick) is Missing.LOST:
        pass_time(client, 0.02)
    assert image(client).width == 96


def test_a_camera_without_power_gives_nothing() -> None:
    client = scene()
    inject(client, PowerLoss())
    with pytest.raises(RequestRefused, match="no picture of 'eye' has come: the camera has no power"):
        image(client)
    assert "pictures in a row have not arrived, in 0.50 s" in confirmed(client)
    clear(client)
    assert image(client).width == 96


def test_cameras_of_robots_are_devices_of_theirs() -> None:
    client = scene()
    [robot] = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    assert "front" in robot.devices
    inject(client, noise(0.1), "front", ROBOT)
    assert "gaussian_noise of turtlebot4/front takes effect" in confirmed(client)
    clear(client)  # of free cameras only
    assert list(feed(client, FRONT).faults) == ["gaussian_noise"]
    clear(client, robot=ROBOT)
    assert feed(client, FRONT).faults == {}


def test_a_robot_without_power_has_no_pictures() -> None:
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


def test_resets_clear_faults_and_end_their_measurements() -> None:
    client = scene()
    inject(client, Delay(time=5.0), limit=100.0)
    inject(client, Delay(time=5.0), "lidar", ROBOT, 100.0, "scans")
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.STATE))
    assert feed(client).faults == {}
    for name in ("fault", "scans"):
        client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id=name, robot=ROBOT, distance=1.0))  # the id is free
    ended = {each.id: each for each in client.advance(1.0).occurrences}
    assert {name: ended[name].outcome for name in ("fault", "scans")} == {
        "fault": Outcome.CANCELED,
        "scans": Outcome.CANCELED,
    }


def test_cancelling_the_measurement_clears_the_fault() -> None:
    client = scene()
    inject(client, Delay(time=5.0))
    with pytest.raises(RequestRefused, match="the id 'fault' is in use"):
        inject(client, Freeze())
    client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="fault"))
    assert client.run_until("fault")[0].outcome is Outcome.CANCELED
    assert feed(client).faults == {}


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
    assert (feed(client, FRONT)._frozen, len(feed(fork)._under_way)) == (feed(fork, FRONT)._frozen, 5)


def test_asking_for_pictures_changes_nothing() -> None:
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


def test_no_fault_where_there_is_no_rendering(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def blind(self: object, view: object) -> Picture:
        raise NoRendering("the lights are out")

    monkeypatch.setattr(type(empty.simulator.simulation.engine), "render", blind)
    with pytest.raises(RequestRefused, match="no picture can be taken: the lights are out"):
        inject(empty, noise(0.1), "front", ROBOT)
    inject(empty, PowerLoss(), "robot", ROBOT)  # for which nothing has to be drawn
    assert "front: " in confirmed(empty)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (GaussianNoise(deviation={}), "deviations are zero or more, and not all of them zero"),
        (GaussianNoise(deviation={Quantity.LENGTH: 0.1}), "gaussian_noise of length: it can be of brightness"),
        (noise(NAN), "no finite number"),
        (noise(1e-5), "gaussian_noise of brightness by 1e-05 is rounded to nothing: it has to be 0.0004 at least"),
        (bias(0.001), "bias of brightness by 0.001 is rounded to nothing: it has to be 0.002 at least"),
        (bias(0.0), "a bias of nothing is none"),
        (DeadPixels(share=1.1), "the share is 1.1"),
        (DeadPixels(share=1e-5), "a share of 1e-05 of 6144 pixels is not one pixel"),
        (DeadArea(left=0.5, top=0.0, right=0.4, bottom=1.0), "not from 0.5 to 0.4 across and from 0 to 1 down"),
        (DeadArea(left=NAN, top=0.0, right=0.4, bottom=1.0), "an area lies within 0 and 1"),
        (DeadArea(left=0.5, top=0.0, right=0.502, bottom=1.0), "no pixel lies from 0.5 to 0.502 across"),
        (Delay(time=11.0), "a delay lasts from 0.02 s to 10 s, not 11 s"),
        (MessageLoss(probability=0.0), "the probability is 0"),
        (BeamLoss(share=0.5), "eye cannot have beam_loss: it has no beams"),
        (WheelSlip(left=0.5, right=0.5), "eye cannot have wheel_slip: it has no wheels"),
    ],
    ids=str,
)  # fmt: skip
def test_faults_that_make_no_sense_are_refused(fault: Fault, message: str) -> None:
    client = scene()
    with pytest.raises(RequestRefused, match=message):
        inject(client, fault)
    assert client.simulator.simulation.camera_faults.goals == ()


def test_cameras_that_are_not_there_are_refused_with_those_that_are() -> None:
    client = scene()
    with pytest.raises(RequestRefused, match="there is no free camera 'nose': there are eye"):
        inject(client, Freeze(), "nose")
    with pytest.raises(RequestRefused, match=r"turtlebot4 has no device 'back': it has .*front"):
        inject(client, Freeze(), "back", ROBOT)
    with pytest.raises(RequestRefused, match="lidar cannot have dead_pixels: it has no pixels"):
        inject(client, DeadPixels(share=0.1), "lidar", ROBOT)


def test_pictures_that_are_kept_have_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    client = scene()
    monkeypatch.setattr(cameras, "MAX_KEPT", 260_000)  # 14 pictures of this size
    inject(client, Delay(time=1.0))
    inject(client, Delay(time=1.2), name="longer")  # in the place of the first
    with pytest.raises(
        RequestRefused, match=r"freeze of 'turtlebot4/front' keeps .* MB of pictures, .* 0 MB are left"
    ):
        inject(client, Freeze(), "front", ROBOT)
    pass_time(client, 2.0)
    assert len(feed(client)._under_way) * camera_feed.PERIOD * 0.02 <= 1.2 + 0.2
