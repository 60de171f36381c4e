from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.geometry import Vector, quaternion
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyState
from sim_nodes.robots.declaration import ImuDeclaration
from sim_nodes.sensors.base import Imu, Inertial

EXACT = ImuDeclaration(
    rate=50.0, accelerometer_noise=0.0, accelerometer_bias=0.0, gyroscope_noise=0.0, gyroscope_bias=0.0
)
NOISY = EXACT.model_copy(update={"accelerometer_noise": 0.3, "gyroscope_noise": 0.1})
REST = BodyState((0.0, 0.0, 0.0))


def readings(*states: BodyState, declaration: ImuDeclaration = EXACT, seed: int = 0) -> list[Inertial]:
    """Return the samples of an IMU in the ticks of states."""
    queue = iter(states)
    imu = Imu(declaration, Noise(seed, "imu"), Noise(seed, "bias"), lambda: next(queue))
    return [imu.read(tick) for tick in range(len(states))]


def moving(linear: Vector, yaw: float = 0.0, angular: Vector = (0.0, 0.0, 0.0)) -> BodyState:
    return BodyState((0.0, 0.0, 0.0), quaternion(0.0, 0.0, yaw), linear, angular)


def test_an_imu_at_rest_measures_gravity_upwards() -> None:
    for reading in readings(REST, REST):
        np.testing.assert_allclose(reading.acceleration, (0.0, 0.0, 9.81))
        np.testing.assert_allclose(reading.angular_rate, (0.0, 0.0, 0.0))


def test_a_tilted_imu_measures_gravity_along_its_axes() -> None:
    [reading] = readings(BodyState((0.0, 0.0, 0.0), quaternion(0.0, math.radians(-30), 0.0)))
    np.testing.assert_allclose(reading.acceleration, (9.81 / 2, 0.0, 9.81 * math.cos(math.radians(30))))


def test_accelerations_are_measured_in_the_frame_of_the_base() -> None:
    heading = math.pi / 2
    *_, reading = readings(moving((0.0, 0.0, 0.0), heading), moving((0.0, 0.02, 0.0), heading, (0.0, 0.0, 0.7)))
    np.testing.assert_allclose(reading.acceleration, (1.0, 0.0, 9.81), atol=1e-12)
    np.testing.assert_allclose(reading.angular_rate, (0.0, 0.0, 0.7), atol=1e-12)


def test_contacts_while_inactive_are_not_reported_later() -> None:
    states = iter((REST, moving((5.0, 0.0, 0.0))))
    imu = Imu(EXACT, Noise(0, "imu"), Noise(0, "bias"), lambda: next(states))
    imu.read(0)
    np.testing.assert_allclose(imu.read(100).acceleration, (0.0, 0.0, 9.81))


def test_noise_has_its_deviation_and_depends_on_the_tick() -> None:
    found = readings(*[REST] * 500, declaration=NOISY)
    assert np.std([reading.acceleration - (0.0, 0.0, 9.81) for reading in found]) == pytest.approx(0.3, rel=0.1)
    assert np.std([reading.angular_rate for reading in found]) == pytest.approx(0.1, rel=0.1)
    again = readings(*[REST] * 500, declaration=NOISY)
    np.testing.assert_array_equal(found[77].acceleration, again[77].acceleration)


def test_biases_are_constant_and_depend_on_the_seed() -> None:
    declaration = EXACT.model_copy(update={"accelerometer_bias": 0.2, "gyroscope_bias": 0.1})
    first, later = readings(REST, REST, declaration=declaration)
    [other] = readings(REST, declaration=declaration, seed=1)
    np.testing.assert_array_equal(first.acceleration, later.acceleration)
    assert np.abs(first.acceleration - (0.0, 0.0, 9.81)).max() > 0.01
    assert not np.allclose(first.angular_rate, other.angular_rate)
