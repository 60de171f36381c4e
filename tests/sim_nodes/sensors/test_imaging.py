"""Depth cameras and segmentation against known distances and entities, in both engines."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import Array
from sim_nodes.views import NoRendering
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import needs_pictures
from tests.sim_nodes.sensors.bench import latest, next_sample, room_with

DEPTH = """  - {kind: depth_camera, name: deep, link: base_link, x: 0.25, z: 0.5, fov: 1.2, width: 96, height: 64,
     min_range: 0.2, max_range: 6.0%s}
"""
SEGMENTS = """  - {kind: segmentation, name: eye, link: base_link, x: 0.25, z: 0.5, pitch: 0.3, fov: 1.2,
     width: 96, height: 64%s}
"""
FOCAL = 32.0 / math.tan(0.6)  # [pixels]


def depths_of(sample: wire.SensorSample) -> Array:
    assert sample.depth is not None
    depth = sample.depth
    return np.frombuffer(depth.depths, "<f4").reshape(depth.height, depth.width).astype(float)


def seen_by(sample: wire.SensorSample) -> dict[str, wire.SeenEntity]:
    assert sample.segmentation is not None
    return {each.entity: each for each in sample.segmentation.seen}


@pytest.mark.parametrize("engine", ENGINES)
def test_depths_are_those_of_wall_and_floor(engine: str, tmp_path: Path) -> None:
    needs_pictures(engine)
    client = Client(room_with(tmp_path, DEPTH % ""), engine=engine)
    client.advance(1.0)  # until the robot rests
    depths = depths_of(next_sample(client, "deep"))
    assert depths.shape == (64, 96)
    assert depths[28:36, 30:66] == pytest.approx(2.75, abs=0.02)  # a plane has one depth, as along the axis
    row = 60
    floor = 0.5 * FOCAL / (row + 0.5 - 32)
    assert depths[row, 48] == pytest.approx(floor, rel=0.03)


def test_both_engines_measure_the_same_depths(tmp_path: Path) -> None:
    for engine in ENGINES:
        needs_pictures(engine)
    world = room_with(tmp_path, DEPTH % "")
    clients = [Client(world, engine=engine) for engine in ENGINES]
    for client in clients:
        client.advance(1.0)
    first, second = (depths_of(next_sample(client, "deep")) for client in clients)
    both = np.isfinite(first) & np.isfinite(second)
    assert (np.isfinite(first) == np.isfinite(second)).mean() > 0.97  # but for edges
    errors = np.abs(first[both] / second[both] - 1.0)
    assert np.median(errors) < 0.01
    assert np.quantile(errors, 0.95) < 0.1  # robots stand a little differently


def test_noise_grows_with_the_square_of_the_distance(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    noisy = DEPTH.replace("max_range: 6.0", "max_range: 20.0") % ", noise: 0.002, noise_growth: 0.01"
    client = Client(room_with(tmp_path, noisy), 4)
    depths = depths_of(next_sample(client, "deep"))
    assert depths[20:34, 20:76].std() == pytest.approx(0.002 + 0.01 * 2.75**2, rel=0.1)
    again = depths_of(next_sample(Client(room_with(tmp_path, noisy), 4), "deep"))
    np.testing.assert_array_equal(again, depths)


def test_far_surfaces_and_lost_pixels_are_infinite(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    near = DEPTH.replace("max_range: 6.0", "max_range: 2.0") % ", dropout: 0.25"
    depths = depths_of(next_sample(Client(room_with(tmp_path, near)), "deep"))
    assert np.isinf(depths[32, 48])
    assert np.isfinite(depths[60]).mean() == pytest.approx(0.75, abs=0.15)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_picture_of_an_rgbd_camera_is_registered(engine: str, tmp_path: Path) -> None:
    needs_pictures(engine)
    client = Client(room_with(tmp_path, DEPTH.replace("depth_camera", "rgbd_camera") % ""), engine=engine)
    client.spawn("box", pose(1.5, 0.0, z=0.4))
    client.advance(1.0)
    sample = next_sample(client, "deep")
    assert sample.depth is not None
    depths = depths_of(sample)
    picture = np.frombuffer(sample.depth.picture, np.uint8).reshape(64, 96, 3).astype(float)
    floor = 0.5 * FOCAL / (np.arange(64) + 0.5 - 32)
    box = (depths < 0.9 * floor[:, None]) & (floor[:, None] > 0.0) & (depths < 1.3)
    wall = (depths > 2.7) & (depths < 2.8)
    assert box.sum() > 50
    assert np.abs(picture[box].mean(axis=0) - picture[wall].mean(axis=0)).max() > 30


@pytest.mark.parametrize("engine", ENGINES)
def test_segmentation_boxes_the_entities_in_view(engine: str, tmp_path: Path) -> None:
    needs_pictures(engine)
    client = Client(room_with(tmp_path, SEGMENTS % ""), engine=engine)
    client.ask(wire.WATCH_SIGHT, wire.WatchSight(id="sight", robot=ROBOT, sensor="eye", entity="box"))
    assert client.advance(0.5).occurrences == ()
    client.spawn("box", pose(1.5, 0.2, z=0.2))
    client.run_until("sight")
    client.advance(1.5)
    sample = next_sample(client, "eye")
    seen = seen_by(sample)
    assert {"box", "ahead"} <= seen.keys()
    assert "floor" not in seen
    box = seen["box"]
    assert box.left < 48 - FOCAL * 0.2 / 1.25 < box.right
    assert sample.segmentation is not None
    labels = np.frombuffer(sample.segmentation.labels, "<u2").reshape(64, 96)
    mask = labels == sample.segmentation.names.index("box") + 1
    assert mask.sum() == box.pixels
    assert mask[box.top : box.bottom, box.left : box.right].sum() == box.pixels
    assert 0.3 < box.pixels / ((box.right - box.left) * (box.bottom - box.top)) <= 1.0


def test_a_share_of_the_picture_can_be_waited_for(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    client = Client(room_with(tmp_path, SEGMENTS % ", min_pixels: 3"))
    for name, share in (("some", 0.1), ("most", 0.9)):
        watch = wire.WatchSight(id=name, robot=ROBOT, sensor="eye", entity="ahead", share=share)
        client.ask(wire.WATCH_SIGHT, watch)
    assert [each.id for each in client.advance(1.0).occurrences] == ["some"]


@pytest.mark.parametrize(
    ("fault", "what"),
    [
        (wire.Bias(offset={wire.Quantity.LENGTH: 0.1}), "deep"),
        (wire.BeamLoss(share=0.2), "deep"),
        (wire.Delay(time=0.3), "eye"),
        (wire.PowerLoss(), "eye"),
    ],
)
def test_faults_act_on_images(fault: wire.Fault, what: str, tmp_path: Path) -> None:
    needs_pictures("mujoco")
    client = Client(room_with(tmp_path, DEPTH % ", noise: 0.01" + SEGMENTS % ""))
    client.ask(wire.INJECT_FAULT, wire.InjectFault(id="f", robot=ROBOT, device=what, fault=fault, limit=20.0))
    assert client.run_until("f")[0].outcome is Outcome.SUCCEEDED


def test_frozen_images_repeat(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    client = Client(room_with(tmp_path, DEPTH % "" + SEGMENTS % ""))
    client.ask(wire.DRIVE, wire.Drive(id="d", robot=ROBOT, linear=0.0, angular=0.5, duration=20.0))
    for device in ("eye", "deep"):
        request = wire.InjectFault(id=device, robot=ROBOT, device=device, fault=wire.Freeze(), limit=20.0)
        client.ask(wire.INJECT_FAULT, request)
    ended: set[str] = set()
    while len(ended) < 2:
        ended |= {each.id for each in client.advance(20.0).occurrences if each.outcome is Outcome.SUCCEEDED}
        assert client.simulator.simulation.time < 20.0
    before = latest(client, "eye")
    assert next_sample(client, "eye").segmentation == before.segmentation


def test_long_delays_of_large_images_are_refused(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    large = DEPTH.replace("width: 96, height: 64", "width: 1024, height: 1024") % ", rate: 50"
    client = Client(room_with(tmp_path, large))
    request = wire.InjectFault(id="f", robot=ROBOT, device="deep", fault=wire.Delay(time=5.0), limit=20.0)
    with pytest.raises(RequestRefused, match="keeps 2097 MB of images"):
        client.ask(wire.INJECT_FAULT, request)


def test_images_without_rendering_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client(room_with(tmp_path, DEPTH % ""))

    def no_rendering(*_: object) -> None:
        raise NoRendering("install OSMesa")

    monkeypatch.setattr(type(client.simulator.simulation.engine), "render_depth", no_rendering)
    with pytest.raises(RequestRefused, match="cannot render 'deep': install OSMesa"):
        client.ask(wire.WATCH_SENSOR, wire.WatchSensor(id="w", robot=ROBOT, sensor="deep"))
    client.advance(1.0)


def test_images_continue_from_snapshots(tmp_path: Path) -> None:
    needs_pictures("mujoco")
    world = room_with(tmp_path, DEPTH % ", noise: 0.01" + SEGMENTS % "")
    client = Client(world, 5)
    for sensor in ("deep", "eye"):
        next_sample(client, sensor)
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    fork = Client(world, 6)
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    for each in (client, fork):
        each.advance(1.0)
    assert [latest(fork, name) for name in ("deep", "eye")] == [latest(client, name) for name in ("deep", "eye")]


def test_other_sensors_see_nobody(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, DEPTH % ""))
    with pytest.raises(RequestRefused, match="turtlebot4/deep is not a segmentation sensor"):
        client.ask(wire.WATCH_SIGHT, wire.WatchSight(id="w", robot=ROBOT, sensor="deep", entity="box"))


def test_too_many_pixels_are_refused(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="'deep' has 2048 x 2048 pixels; expected up to 1048576"):
        load_world(room_with(tmp_path, DEPTH.replace("width: 96, height: 64", "width: 2048, height: 2048") % ""))
