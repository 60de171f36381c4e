"""What faults make of samples on their way."""

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
from sim_nodes.sensors.beams import dead_beams, lost_beams
from tests.sim_nodes.faults.ruler import BEAMS, Reading, Ruler, feed

TICKS = 40


def arrivals(*faults: SensorFault, seed: int = 0) -> dict[int, tuple[int, Reading]]:
    """For each tick in which a sample arrives, the tick that it is of and its data."""
    way = feed(*faults, seed=seed)
    found = {}
    for tick in range(TICKS):
        way.pass_tick(tick)
        if way.arrived is not None:
            assert way.latest is way.arrived
            found[tick] = (way.arrived.tick, way.arrived.data)
    return found


def test_without_faults_samples_arrive_at_once_and_as_they_were_taken() -> None:
    found = arrivals()
    assert list(found) == list(range(0, TICKS, 2))
    for tick, (taken, data) in found.items():
        assert taken == tick
        np.testing.assert_array_equal(data.ranges, Ruler().read(tick).ranges)


def test_a_sensor_that_nobody_uses_does_not_sense() -> None:
    way = feed()
    way.in_use = False
    way.pass_tick(0)
    assert (way.truth, way.arrived, way.latest) == (None, None, None)


def test_delayed_samples_come_late_with_their_own_time() -> None:
    found = arrivals(Delay(time=0.11))
    assert [tick - taken for tick, (taken, _) in found.items()] == [6] * len(found)  # 0.12 s, in whole ticks
    assert len(found) == TICKS // 2 - 3


def test_frozen_samples_have_the_values_of_the_first() -> None:
    found = arrivals(Freeze())
    assert list(found) == [taken for taken, _ in found.values()]
    for _, data in found.values():
        np.testing.assert_array_equal(data.ranges, found[0][1].ranges)


def test_a_sensor_without_power_sends_nothing_and_what_is_under_way_is_lost() -> None:
    assert arrivals(PowerLoss()) == {}
    way = feed(Delay(time=0.2))
    way.pass_tick(0)
    way.put(PowerLoss())
    for tick in range(1, TICKS):
        way.pass_tick(tick)
        assert way.arrived is None


def test_messages_are_lost_at_random_by_the_seed() -> None:
    first, again, other = (arrivals(MessageLoss(probability=0.5), seed=seed) for seed in (1, 1, 2))
    assert list(first) == list(again) != list(other)
    assert 4 < len(first) < 16


def test_of_n_beams_the_whole_part_of_the_share_is_lost_anew_in_each_scan() -> None:
    scans = [data.ranges for _, data in arrivals(BeamLoss(share=0.25), DeadBeams(beams=())).values()]
    sound = [Ruler().read(tick).ranges for tick in range(0, TICKS, 2)]
    lost = [np.isinf(scan) & np.isfinite(of) for scan, of in zip(scans, sound, strict=True)]
    assert all(12 <= mask.sum() <= 22 for mask in lost)  # of 22 some saw nothing anyway
    assert any(not np.array_equal(lost[0], mask) for mask in lost)


def test_shares_are_counted_without_the_errors_of_floats() -> None:
    assert [lost_beams(share, 100) for share in (0.29, 0.57, 0.58, 0.999)] == [29, 57, 58, 99]


def test_beams_of_a_sector_see_nothing() -> None:
    scan = arrivals(DeadSector(start=-0.5, end=0.5))[0][1].ranges
    ahead = np.abs(Ruler.bearings) <= 0.5
    assert np.isinf(scan[ahead]).all()
    assert np.isfinite(scan[~ahead]).sum() == np.isfinite(Ruler().read(0).ranges[~ahead]).sum()


def test_a_sector_may_lie_across_the_back() -> None:
    behind = dead_beams(DeadSector(start=3.0, end=-3.0), Ruler.bearings)
    assert set(behind) == set(np.flatnonzero(np.abs(Ruler.bearings) >= 3.0))
    assert len(dead_beams(DeadSector(start=1.0, end=1.0), Ruler.bearings)) == BEAMS


def test_values_are_off_by_the_bias_and_angles_stay_angles() -> None:
    found = arrivals(Bias(offset={Quantity.LENGTH: 0.25, Quantity.ANGLE: 0.1}))[0][1]
    sound = Ruler().read(0)
    np.testing.assert_allclose(found.ranges, sound.ranges + 0.25)
    assert found.angle == pytest.approx(sound.angle + 0.1 - 2 * np.pi)


def test_noise_of_one_quantity_does_not_change_that_of_another() -> None:
    length, angle = {Quantity.LENGTH: 0.1}, {Quantity.ANGLE: 0.1}
    one, both = (arrivals(GaussianNoise(deviation=deviation))[0][1].angle for deviation in (angle, length | angle))
    assert one == both != Ruler().read(0).angle


def test_what_noise_takes_beyond_the_limits_is_not_seen() -> None:
    scan = arrivals(GaussianNoise(deviation={Quantity.LENGTH: 1.0}))[0][1].ranges
    finite = scan[np.isfinite(scan)]
    assert len(finite) < np.isfinite(Ruler().read(0).ranges).sum()
    assert Ruler.limits[0] <= finite.min()
    assert finite.max() <= Ruler.limits[1]


def test_a_lifted_fault_is_gone() -> None:
    way = feed(Delay(time=0.2), Freeze(), Bias(offset={Quantity.LENGTH: 1.0}))
    way.pass_tick(0)
    for kind in ("delay", "freeze", "bias"):
        way.lift(kind)
    way.pass_tick(2)
    assert way.arrived is not None
    assert way.arrived.tick == 2
    np.testing.assert_array_equal(way.arrived.data.ranges, Ruler().read(2).ranges)
