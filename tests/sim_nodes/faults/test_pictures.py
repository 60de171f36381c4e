"""Faults of cameras are found by their pictures; what does nothing, or something else, is not found."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from seoro.bridges.wire import (
    Bias,
    CameraFault,
    DeadArea,
    DeadPixels,
    Delay,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Quantity,
)
from sim_nodes.faults.check import Check
from sim_nodes.faults.levels import Levels
from sim_nodes.faults.pictures import camera_check, measure
from sim_nodes.noise import Noise
from sim_nodes.sensors.camera_feed import CameraFeed, Missing
from sim_nodes.sensors.pixels import with_errors
from sim_nodes.views import Lens, Picture

LENS = Lens(width=48, height=32)
PATIENCE = 200  # ticks; a fault that takes effect is found in fewer
LEFT_HALF = DeadArea(left=0.0, top=0.0, right=0.5, bottom=1.0)


class Panorama:
    """What a camera sees that turns on the spot: all levels of brightness, of which many are at both ends."""

    def __init__(self) -> None:
        self.tick = 0

    def look(self) -> Picture:
        across = np.arange(LENS.width)[None, :, None] + self.tick
        down, colours = np.arange(LENS.height)[:, None, None], np.arange(3)[None, None, :]
        picture: Picture = np.clip((across * 7 + down * 11 + colours * 40) % 400 - 70, 0, 255).astype(np.uint8)
        return picture


def black() -> Picture:
    return np.zeros((LENS.height, LENS.width, 3), dtype=np.uint8)


def noise(deviation: float) -> GaussianNoise:
    return GaussianNoise(deviation={Quantity.BRIGHTNESS: deviation})


def bias(offset: float) -> Bias:
    return Bias(offset={Quantity.BRIGHTNESS: offset})


class Way:
    """The way of a camera's pictures, with faults on it."""

    def __init__(self, *faults: CameraFault, seed: int = 0, look: Callable[[], Picture] | None = None) -> None:
        self.panorama = Panorama()
        self.feed = CameraFeed(LENS, look or self.panorama.look, lambda purpose: Noise(seed, purpose))
        for fault in faults:
            self.feed.put(fault)

    def pass_tick(self, tick: int) -> None:
        self.panorama.tick = tick
        if self.feed.is_busy:
            self.feed.pass_tick(tick)

    def picture(self, tick: int) -> Picture:
        seen = self.feed.exposure(tick)
        assert seen is not None
        return self.feed.given(seen).picture


def measured(fault: CameraFault, way: Way, ticks: int = PATIENCE) -> tuple[int, Check]:
    """Measure a fault until it is found, or for a number of ticks, on a way on which there may be others."""
    check = camera_check(fault)
    for tick in range(ticks):
        way.pass_tick(tick)
        measure(check, way.feed, tick)
        if check.holds:
            return tick, check
    return ticks, check


FAULTS: tuple[CameraFault, ...] = (
    noise(0.002),
    noise(0.05),
    noise(0.9),
    bias(0.01),
    bias(-0.4),
    bias(1.5),
    DeadPixels(share=0.01),
    DeadPixels(share=1.0),
    LEFT_HALF,
    MessageLoss(probability=0.3),
    MessageLoss(probability=1.0),
    Freeze(),
    Delay(time=0.02),
    Delay(time=0.55),
    PowerLoss(),
)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_fault_is_found(fault: CameraFault, seed: int) -> None:
    ticks, check = measured(fault, Way(fault, seed=seed))
    assert check.holds, check.figures()
    assert ticks < 80


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_sound_camera_has_no_fault(fault: CameraFault) -> None:
    _, check = measured(fault, Way())
    assert not check.holds, check.figures()
    assert check.figures()


@pytest.mark.parametrize(
    ("fault", "instead"),
    [
        (noise(0.05), noise(0.045)),
        (noise(0.05), bias(0.05)),
        (bias(0.1), bias(0.09)),
        (bias(0.1), noise(0.1)),
        (DeadPixels(share=0.1), DeadPixels(share=0.09)),
        (LEFT_HALF, DeadArea(left=0.0, top=0.0, right=0.45, bottom=1.0)),
        (Delay(time=0.5), Delay(time=0.8)),
        (Delay(time=0.5), Freeze()),
        (Freeze(), Delay(time=0.5)),
        (PowerLoss(), MessageLoss(probability=0.5)),
    ],
    ids=str,
)
def test_another_effect_is_not_taken_for_it(fault: CameraFault, instead: CameraFault) -> None:
    _, check = measured(fault, Way(instead))
    assert not check.holds, check.figures()


@pytest.mark.parametrize("fault", FAULTS[:-1], ids=str)
def test_a_fault_is_found_beside_others(fault: CameraFault) -> None:
    others: list[CameraFault] = [
        noise(0.1),
        bias(0.2),
        DeadPixels(share=0.2),
        MessageLoss(probability=0.2),
        Delay(time=0.3),
    ]
    way = Way(*(other for other in others if other.kind != fault.kind), fault)
    _, check = measured(fault, way)
    assert check.holds, check.figures()


@pytest.mark.parametrize("fault", [noise(0.1), bias(-0.1), LEFT_HALF, Freeze()], ids=str)
def test_what_cannot_be_seen_is_not_found(fault: CameraFault) -> None:
    """A camera in the dark: of noise half is left, of the rest nothing."""
    _, check = measured(fault, Way(fault, look=black))
    assert check.holds == isinstance(fault, GaussianNoise), check.figures()


def test_frozen_noise_is_told_from_noise() -> None:
    way = Way(noise(0.1), Freeze(), look=black)
    assert measured(Freeze(), way)[1].holds
    way = Way(Freeze())
    way.pass_tick(0)
    way.feed.put(noise(0.1))
    assert not measured(noise(0.1), way)[1].holds


@pytest.mark.parametrize(("deviation", "offset"), [(0.0, 0.7), (0.3, 0.0), (5.0, -3.0), (90.0, 40.0)])
def test_levels_are_expected_as_they_come(deviation: float, offset: float) -> None:
    levels = Levels(deviation, offset)
    for level in (0, 3, 128, 255):
        picture = np.full((200, 200, 3), level, dtype=np.uint8)
        errors = with_errors(picture, deviation, offset, np.random.default_rng(level)).astype(float) - level
        counts = np.bincount([level], minlength=256)
        for power in (1, 2):
            expected = levels.expected(counts, offset, power)
            values = (errors - offset) ** power
            spread = np.sqrt(expected.variance / values.size)
            assert values.mean() == pytest.approx(expected.mean, abs=5.0 * spread + 1e-9)
            assert values.var() == pytest.approx(expected.variance, rel=0.05, abs=1e-2)


def test_equal_seeds_spoil_equally_and_each_time_has_its_own_noise() -> None:
    faults = (noise(0.1), DeadPixels(share=0.5))
    first, again, other = Way(*faults), Way(*faults), Way(*faults, seed=1)
    np.testing.assert_array_equal(first.picture(3), again.picture(3))
    np.testing.assert_array_equal(first.picture(3), first.picture(3))
    assert (first.picture(3) != first.picture(4)).mean() > 0.3
    assert (first.picture(3) != other.picture(3)).mean() > 0.3
    dark = (first.picture(3) == 0).all(axis=2) & (first.picture(4) == 0).all(axis=2)
    assert dark.sum() >= LENS.width * LENS.height // 2


def test_an_area_has_the_pixels_whose_middle_lies_in_it() -> None:
    way = Way(DeadArea(left=0.25, top=0.5, right=0.5, bottom=1.0), look=lambda: black() + np.uint8(9))
    rows, columns = np.nonzero((way.picture(0) == 0).all(axis=2))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (16, 31, 12, 23)


def test_a_late_camera_keeps_no_more_than_it_needs() -> None:
    way = Way(Delay(time=1.0))
    given = []
    for tick in range(200):
        way.pass_tick(tick)
        seen = way.feed.exposure(tick)
        assert (seen is None) == (way.feed.missing(tick) is Missing.UNDER_WAY) == (tick < 50)
        if seen is not None:
            given.append(tick - seen.tick)
    assert (min(given), max(given)) == (50, 54)
    assert len(way.feed._under_way) <= 12
