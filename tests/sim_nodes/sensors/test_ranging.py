"""3D lidar and sonar against known walls and the floor, in both engines."""

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
from sim_nodes.sensors.ranging import cone_directions
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.graph import differences
from tests.sim_nodes.sensors.bench import latest, next_sample, room_with

LIDAR = """  - {kind: lidar_3d, name: top, link: base_link, x: 0.1, z: 0.5, rings: 5, beams: 120, lowest: -0.4,
     highest: 0.4, min_range: 0.2, max_range: 8.0%s}
"""
SONAR = """  - {kind: sonar, name: nose, link: base_link, x: 0.2, z: 0.3, aperture: 0.4, min_range: 0.1,
     max_range: 4.0%s}
"""


def points_of(sample: wire.SensorSample) -> Array:
    """Return the points of a cloud in the frame of the base, shape (rings, beams, 3)."""
    assert sample.cloud is not None
    points = np.frombuffer(sample.cloud.points, "<f4").reshape(sample.cloud.rings, sample.cloud.beams, 3)
    moved: Array = np.add(points, [0.1, 0.0, 0.5])
    return moved


@pytest.mark.parametrize("engine", ENGINES)
def test_points_lie_on_walls_and_floor(engine: str, tmp_path: Path) -> None:
    points = points_of(next_sample(Client(room_with(tmp_path, LIDAR % ""), engine=engine), "top"))
    assert points.shape == (5, 120, 3)
    ahead, down, left = points[2, 60], points[0, 60], points[2, 90]
    assert ahead == pytest.approx([3.0, 0.0, 0.5], abs=0.01)
    assert down == pytest.approx([0.1 + 0.5 / math.tan(0.4), 0.0, 0.0], abs=0.01)
    assert left == pytest.approx([0.1, 2.0, 0.5], abs=0.01)
    assert np.isnan(points[2, 30]).all()  # the room is open to the right


def test_both_engines_measure_the_same_points(tmp_path: Path) -> None:
    world = room_with(tmp_path, LIDAR % "")
    first, second = (points_of(next_sample(Client(world, engine=engine), "top")) for engine in ENGINES)
    assert (np.isnan(first) == np.isnan(second)).mean() > 0.99  # but for beams along edges
    assert np.nanquantile(np.abs(first - second), 0.99) < 0.03  # robots stand a little differently


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sonar_measures_the_nearest_surface_in_its_cone(engine: str, tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, SONAR % ""), engine=engine)
    sample = next_sample(client, "nose")
    assert sample.echo is not None
    # The lowest rays meet the floor nearer than the wall.
    assert sample.echo.range == pytest.approx(0.3 / math.sin(0.2), rel=0.06)
    client.spawn("box", pose(1.2, 0.0, z=0.4))
    sample = next_sample(client, "nose")
    assert sample.echo is not None
    assert 0.7 < sample.echo.range < 1.1


def test_no_echo_within_reach_is_infinite(tmp_path: Path) -> None:
    sonar = SONAR.replace("z: 0.3", "z: 1.0").replace("max_range: 4.0", "max_range: 1.0") % ""
    sample = next_sample(Client(room_with(tmp_path, sonar)), "nose")
    assert sample.echo == wire.RangeSample(range=math.inf)


def test_noise_has_the_declared_deviation_and_repeats_by_seed(tmp_path: Path) -> None:
    world = room_with(tmp_path, LIDAR % ", noise: 0.05, dropout: 0.2")
    seen = [points_of(next_sample(Client(world, seed), "top")) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(seen[0], seen[1])
    assert not np.array_equal(seen[0], seen[2], equal_nan=True)
    clean = points_of(next_sample(Client(room_with(tmp_path, LIDAR % ""), 1), "top"))
    errors = np.linalg.norm(seen[0] - clean, axis=2)
    assert math.sqrt(np.nanmean(errors**2)) == pytest.approx(0.05, rel=0.15)
    lost = np.isnan(seen[0][..., 0]) & ~np.isnan(clean[..., 0])
    assert lost.sum() / (~np.isnan(clean[..., 0])).sum() == pytest.approx(0.2, abs=0.06)


def test_faults_of_a_lidar_act_on_a_3d_lidar(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, LIDAR % ", noise: 0.01"))
    for name, fault in (
        ("sector", wire.DeadSector(start=-0.1, end=0.1)),
        ("lost", wire.BeamLoss(share=0.1)),
        ("bias", wire.Bias(offset={wire.Quantity.LENGTH: 0.2})),
    ):
        request = wire.InjectFault(id=name, robot=ROBOT, device="top", fault=fault, limit=20.0)
        client.ask(wire.INJECT_FAULT, request)
        assert client.run_until(name)[0].outcome is Outcome.SUCCEEDED
    points = points_of(latest(client, "top"))
    assert np.isnan(points[2, 60]).all()
    assert np.nanmedian(points[2, 80:100, 1]) > 2.1


def test_waits_for_ranges_see_any_ranging_sensor(tmp_path: Path) -> None:
    lidar = LIDAR.replace("lowest: -0.4", "lowest: -0.1")
    client = Client(room_with(tmp_path, lidar % "" + SONAR % ""))
    for sensor, distance in (("top", 2.0), ("nose", 1.2)):
        watch = wire.WatchRange(id=sensor, robot=ROBOT, sensor=sensor, distance=distance, start=-0.3, end=0.3)
        client.ask(wire.WATCH_RANGE, watch)
    assert client.advance(0.5).occurrences == ()
    client.spawn("box", pose(1.2, 0.0, z=0.45))
    ended: set[str] = set()
    while len(ended) < 2 and client.simulator.simulation.time < 3.0:
        ended |= {each.id for each in client.advance(3.0).occurrences}
    assert ended == {"top", "nose"}


def test_sensors_continue_from_snapshots(tmp_path: Path) -> None:
    world = room_with(tmp_path, LIDAR % ", noise: 0.02" + SONAR % ", noise: 0.02, dropout: 0.3")
    client = Client(world, 5)
    for sensor in ("top", "nose"):
        request = wire.InjectFault(id=sensor, robot=ROBOT, device=sensor, fault=wire.Delay(time=0.25), limit=20.0)
        client.ask(wire.INJECT_FAULT, request)
    client.advance(0.47)
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    fork = Client(world, 6)
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    assert differences(client.simulator.simulation, fork.simulator.simulation) == []
    for each in (client, fork):
        while each.simulator.simulation.time < 1.5:
            each.advance(1.5)
    assert [latest(fork, name) for name in ("top", "nose")] == [latest(client, name) for name in ("top", "nose")]


def test_unused_sensors_are_not_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client(room_with(tmp_path, LIDAR % ""))
    with monkeypatch.context() as broken:
        broken.setattr(type(client.simulator.simulation.engine), "cast_rays", None)
        client.advance(1.0)
    assert next_sample(client, "top").time > 1.0


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        (LIDAR % ", beam: 3", "beam"),
        (LIDAR.replace("rings: 5", "rings: 5000") % "", "600000 beams; expected at most 65536"),
        (LIDAR.replace("min_range: 0.2", "min_range: 9") % "", "`min_range` 9 of 'top' is not below"),
        (LIDAR.replace("name: top", "name: lidar") % "", "duplicate name 'lidar' of a sensor"),
        (LIDAR.replace("name: top", "name: front") % "", "duplicate name 'front'"),
        (LIDAR.replace("base_link", "mast") % "", "unknown link 'mast'"),
        (LIDAR.replace("lidar_3d", "radar") % "", "radar"),
        (LIDAR % ", rate: 1000", "rate"),
    ],
)
def test_invalid_sensors_are_refused_with_a_reason(sensor: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=words):
        load_world(room_with(tmp_path, sensor))


def test_the_default_bearings_are_all_around(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, SONAR % ""))
    half = 180 * 0.01745329252  # the factor of degrees in scenarios
    for sensor in ("nose", "lidar"):
        watch = wire.WatchRange(id=sensor, robot=ROBOT, sensor=sensor, distance=3.2, start=-half, end=half)
        client.ask(wire.WATCH_RANGE, watch)
    assert sorted(each.id for each in client.advance(0.5).occurrences) == ["lidar", "nose"]


def test_a_sensor_without_beams_has_no_ranges(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, SONAR % ""))
    watch = wire.WatchRange(id="w", robot=ROBOT, sensor="imu", distance=1.0, start=0.0, end=1.0)
    with pytest.raises(RequestRefused, match="it has no beams"):
        client.ask(wire.WATCH_RANGE, watch)


def test_rays_fill_a_cone_evenly() -> None:
    rays = cone_directions(0.5, 400)
    angles = np.arccos(rays[:, 0])
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)
    assert angles.max() == pytest.approx(0.25)
    assert (angles < math.acos((1 + math.cos(0.25)) / 2)).mean() == pytest.approx(0.5, abs=0.01)
