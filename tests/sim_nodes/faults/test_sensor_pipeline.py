"""Effects of faults on samples in a pipeline."""

from __future__ import annotations

import numpy as np
import pytest

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
    DeadSector,
    Delay,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Quantity,
    SensorFault,
)
from sim_nodes.sensors.sensor_pipeline import dead_beams, lost_beams
from tests.sim_nodes.faults.ruler import BEAMS, Reading, Ruler, pipeline

TICKS = 40


def arrivals(*faults: SensorFault, seed: int = 0) -> dict[int, tuple[int, Reading]]:
    """Return tick and data of arriving samples, by the tick of arrival."""
    way = pipeline(*faults, seed=seed)
    found = {}
    for tick in range(TICKS):
        way.update(tick)
        if way.arrived is not None:
            assert way.latest is way.arrived
            found[tick] = (way.arrived.tick, way.arrived.data)
    return found


def test_without_faults_samples_arrive_immediately_and_unchanged() -> None:
    found = arrivals()
    assert list(found) == list(range(0, TICKS, 2))
    for tick, (taken, data) in found.items():
        assert taken == tick
        np.testing.assert_array_equal(data.ranges, Ruler().read(tick).ranges)


def test_a_sensor_without_clients_is_inactive() -> None:
    way = pipeline()
    way.in_use = False
    way.update(0)
    assert (way.truth, way.arrived, way.latest) == (None, None, None)


def test_delayed_samples_keep_their_own_time() -> None:
    found = arrivals(Delay(time=0.11))
    assert [tick - taken for tick, (taken, _) in found.items()] == [6] * len(found)  # 0.12 s, in whole ticks
    assert len(found) == TICKS // 2 - 3


def test_frozen_samples_have_the_values_of_the_first() -> None:
    found = arrivals(Freeze())
    assert list(found) == [taken for taken, _ in found.values()]
    for _, data in found.values():
        np.testing.assert_array_equal(data.ranges, found[0][1].ranges)


def test_a_sensor_without_power_loses_samples_in_transit() -> None:
    assert arrivals(PowerLoss()) == {}
    way = pipeline(Delay(time=0.2))
    way.update(0)
    way.add_fault(PowerLoss())
    for tick in range(1, TICKS):
        way.update(tick)
        assert way.arrived is None


def test_messages_are_lost_at_random_by_the_seed() -> None:
    first, again, other = (arrivals(MessageLoss(probability=0.5), seed=seed) for seed in (1, 1, 2))
    assert list(first) == list(again) != list(other)
    assert 4 < len(first) < 16


def test_lost_beams_are_drawn_anew_for_each_scan() -> None:
    scans = [data.ranges for _, data in arrivals(BeamLoss(share=0.25), DeadBeams(beams=())).values()]
    sound = [Ruler().read(tick).ranges for tick in range(0, TICKS, 2)]
    lost = [np.isinf(scan) & np.isfinite(of) for scan, of in zip(scans, sound, strict=True)]
    assert all(12 <= mask.sum() <= 22 for mask in lost)  # of 22 some saw nothing anyway
    assert any(not np.array_equal(lost[0], mask) for mask in lost)


def test_shares_are_counted_without_the_errors_of_floats() -> None:
    assert [lost_beams(share, 100) for share in (0.29, 0.57, 0.58, 0.999)] == [29, 57, 58, 99]


def test_beams_in_a_dead_sector_have_no_return() -> None:
    scan = arrivals(DeadSector(start=-0.5, end=0.5))[0][1].ranges
    ahead = np.abs(Ruler.bearings) <= 0.5
    assert np.isinf(scan[ahead]).all()
    assert np.isfinite(scan[~ahead]).sum() == np.isfinite(Ruler().read(0).ranges[~ahead]).sum()


def test_a_sector_may_cross_the_rear() -> None:
    behind = dead_beams(DeadSector(start=3.0, end=-3.0), Ruler.bearings)
    assert set(behind) == set(np.flatnonzero(np.abs(Ruler.bearings) >= 3.0))
    assert len(dead_beams(DeadSector(start=1.0, end=1.0), Ruler.bearings)) == BEAMS


def test_a_bias_shifts_values_and_wraps_angles() -> None:
    found = arrivals(Bias(offset={Quantity.LENGTH: 0.25, Quantity.ANGLE: 0.1}))[0][1]
    sound = Ruler().read(0)
    np.testing.assert_allclose(found.ranges, sound.ranges + 0.25)
    assert found.angle == pytest.approx(sound.angle + 0.1 - 2 * np.pi)


def test_noise_of_one_quantity_does_not_change_that_of_another() -> None:
    length, angle = {Quantity.LENGTH: 0.1}, {Quantity.ANGLE: 0.1}
    one, both = (arrivals(GaussianNoise(deviation=deviation))[0][1].angle for deviation in (angle, length | angle))
    assert one == both != Ruler().read(0).angle


def test_noise_beyond_the_limits_loses_returns() -> None:
    scan = arrivals(GaussianNoise(deviation={Quantity.LENGTH: 1.0}))[0][1].ranges
    finite = scan[np.isfinite(scan)]
    assert len(finite) < np.isfinite(Ruler().read(0).ranges).sum()
    assert Ruler.limits[0] <= finite.min()
    assert finite.max() <= Ruler.limits[1]


def test_a_removed_fault_has_no_effect() -> None:
    way = pipeline(Delay(time=0.2), Freeze(), Bias(offset={Quantity.LENGTH: 1.0}))
    way.update(0)
    for kind in ("delay", "freeze", "bias"):
        way.remove_fault(kind)
    way.update(2)
    assert way.arrived is not None
    assert way.arrived.tick == 2
    np.testing.assert_array_equal(way.arrived.data.ranges, Ruler().read(2).ranges)
