"""Satellite navigation, and its geodesy against published points."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from sim_nodes.geodesy import GeoPoint, earth_centred, from_earth_centred, from_local
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.graph import differences
from tests.sim_nodes.sensors.bench import latest, next_sample, room_with

GPS = "  - {kind: gps, name: gps, link: base_link, x: 0.1, z: 0.4, rate: 10%s}\n"
PLACE = "geo_origin: {latitude: 48.1, longitude: 11.6, altitude: 520.0}\n"
ORIGIN = GeoPoint(math.radians(48.1), math.radians(11.6), 520.0)


@pytest.mark.parametrize("latitude", [-90.0, -33.9, 0.0, 48.1, 89.999999, 90.0])
@pytest.mark.parametrize("altitude", [-100.0, 0.0, 9000.0])
def test_coordinates_return_to_themselves(latitude: float, altitude: float) -> None:
    point = GeoPoint(math.radians(latitude), 0.7, altitude)
    found = from_earth_centred(earth_centred(point))
    assert found.latitude == pytest.approx(point.latitude, abs=1e-14)
    assert found.altitude == pytest.approx(altitude, abs=1e-6)
    assert earth_centred(found) == pytest.approx(earth_centred(point), abs=1e-7)


def test_earth_centred_coordinates_are_those_of_the_ellipsoid() -> None:
    assert earth_centred(GeoPoint(0.0, 0.0, 0.0)) == pytest.approx([6378137.0, 0.0, 0.0])
    assert earth_centred(GeoPoint(math.pi / 2, 0.0, 0.0)) == pytest.approx([0.0, 0.0, 6356752.314245], abs=1e-6)
    # One second of latitude and longitude at 45 degrees north: 30.87 m and 21.90 m.
    here = GeoPoint(math.pi / 4, 0.0, 0.0)
    second = math.radians(1 / 3600)
    north = from_local(here, (0.0, 30.870, 0.0))
    east = from_local(here, (21.898, 0.0, 0.0))
    assert north.latitude - here.latitude == pytest.approx(second, rel=1e-3)
    assert east.longitude == pytest.approx(second, rel=1e-3)


def test_a_tangent_plane_rises_from_the_earth() -> None:
    far = from_local(ORIGIN, (10_000.0, 0.0, 0.0))
    assert far.altitude - 520.0 == pytest.approx(10_000.0**2 / (2 * 6_390_000), rel=0.01)


def test_a_fix_is_the_place_of_the_antenna(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, GPS % "", PLACE))
    fix = next_sample(client, "gps").fix
    wanted = from_local(ORIGIN, (0.1, 0.0, 0.4))
    assert fix is not None
    assert fix.latitude == pytest.approx(math.degrees(wanted.latitude), abs=1e-7)
    assert fix.longitude == pytest.approx(math.degrees(wanted.longitude), abs=1e-7)
    assert fix.altitude == pytest.approx(520.4, abs=0.01)
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(0.0, 1.5)))
    moved = next_sample(client, "gps").fix
    assert moved is not None
    assert (moved.latitude - fix.latitude) * 111_200 == pytest.approx(1.5, abs=0.02)


def test_noise_and_drift_have_the_declared_deviations(tmp_path: Path) -> None:
    errors = ", noise: 0.5, height_noise: 1.0, drift: 2.0, drift_time: 0.5, rate: 10"
    gps = GPS.replace(", rate: 10", "") % errors
    client = Client(room_with(tmp_path, gps, PLACE), 8)
    sensor = client.simulator.simulation.pipeline(ROBOT, "gps").sensor
    places = np.array([sensor.read(tick).position for tick in range(0, 20_000, 5)]) - [0.1, 0.0, 0.4]
    assert places.std(axis=0) == pytest.approx([math.hypot(2.0, 0.5)] * 2 + [math.hypot(2.0, 1.0)], rel=0.1)
    changes = np.diff(places, axis=0).std(axis=0)
    kept = math.exp(-0.1 / 0.5)
    assert changes[0] == pytest.approx(math.sqrt(2 * 0.5**2 + 2 * 2.0**2 * (1 - kept)), rel=0.05)


def test_a_drift_continues_from_a_snapshot(tmp_path: Path) -> None:
    world = room_with(tmp_path, GPS % ", drift: 2.0", PLACE)
    client, fork = Client(world, 8), Client(world, 9)
    next_sample(client, "gps")
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    assert differences(client.simulator.simulation, fork.simulator.simulation) == []
    for each in (client, fork):
        each.advance(1.0)
    assert latest(client, "gps") == latest(fork, "gps")


def test_a_bias_moves_the_fix(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, GPS % ", noise: 0.1, height_noise: 0.1", PLACE))
    fault = wire.Bias(offset={wire.Quantity.LENGTH: 5.0})
    client.ask(wire.INJECT_FAULT, wire.InjectFault(id="f", robot=ROBOT, device="gps", fault=fault, limit=20.0))
    assert client.run_until("f")[0].outcome is Outcome.SUCCEEDED
    fix = latest(client, "gps").fix
    assert fix is not None
    assert fix.altitude == pytest.approx(525.4, abs=0.5)


def test_a_gps_needs_a_place_on_the_earth(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="'turtlebot4' has a GPS, 'gps'; expected `geo_origin` of the world"):
        load_world(room_with(tmp_path, GPS % ""))
