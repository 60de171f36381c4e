"""Checks of camera faults by images; faults without an effect, or with another one, are not confirmed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

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
from sim_nodes.faults.checks import Check
from sim_nodes.faults.image_checks import camera_check
from sim_nodes.faults.statistics import Levels
from sim_nodes.noise import Noise
from sim_nodes.sensors.camera_pipeline import CameraPipeline, Missing
from sim_nodes.sensors.sensor_pipeline import with_errors
from sim_nodes.views import Lens, Picture

LENS = Lens(width=48, height=32)
PATIENCE = 200  # ticks; sufficient for every check
LEFT_HALF = DeadArea(left=0.0, top=0.0, right=0.5, bottom=1.0)


class Panorama:
    """Views of a camera that turns in place: all levels of brightness, many of them at both ends."""

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


class DelayLine:
    """Pipeline of a camera's images, with faults."""

    def __init__(self, *faults: CameraFault, seed: int = 0, look: Callable[[], Picture] | None = None) -> None:
        self.panorama = Panorama()
        self.pipeline = CameraPipeline(LENS, look or self.panorama.look, lambda purpose: Noise(seed, purpose))
        for fault in faults:
            self.pipeline.add_fault(fault)

    def update(self, tick: int) -> None:
        self.panorama.tick = tick
        if self.pipeline.is_busy:
            self.pipeline.update(tick)

    def picture(self, tick: int) -> Picture:
        seen = self.pipeline.exposure(tick)
        assert seen is not None
        return self.pipeline.given(seen).data


def measured(fault: CameraFault, way: DelayLine, ticks: int = PATIENCE) -> tuple[int, Check[Any]]:
    """Check a fault until it is confirmed, or for a number of ticks, in a pipeline with other faults."""
    check, observe = camera_check(fault, way.pipeline)
    for tick in range(ticks):
        way.update(tick)
        check.observe(observe(tick))
        if check.is_confirmed:
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
    ticks, check = measured(fault, DelayLine(fault, seed=seed))
    assert check.is_confirmed, check.summary()
    assert ticks < 80


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_sound_camera_has_no_fault(fault: CameraFault) -> None:
    _, check = measured(fault, DelayLine())
    assert not check.is_confirmed, check.summary()
    assert check.summary()


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
def test_another_effect_does_not_confirm_a_fault(fault: CameraFault, instead: CameraFault) -> None:
    _, check = measured(fault, DelayLine(instead))
    assert not check.is_confirmed, check.summary()


@pytest.mark.parametrize("fault", FAULTS[:-1], ids=str)
def test_a_fault_is_found_beside_others(fault: CameraFault) -> None:
    others: list[CameraFault] = [
        noise(0.1),
        bias(0.2),
        DeadPixels(share=0.2),
        MessageLoss(probability=0.2),
        Delay(time=0.3),
    ]
    way = DelayLine(*(other for other in others if other.kind != fault.kind), fault)
    _, check = measured(fault, way)
    assert check.is_confirmed, check.summary()


@pytest.mark.parametrize("fault", [noise(0.1), bias(-0.1), LEFT_HALF, Freeze()], ids=str)
def test_invisible_faults_are_not_confirmed(fault: CameraFault) -> None:
    """In the dark, half of a noise remains, and other faults have no effect."""
    _, check = measured(fault, DelayLine(fault, look=black))
    assert check.is_confirmed == isinstance(fault, GaussianNoise), check.summary()


def test_a_freeze_is_distinguished_from_noise() -> None:
    way = DelayLine(noise(0.1), Freeze(), look=black)
    assert measured(Freeze(), way)[1].is_confirmed
    way = DelayLine(Freeze())
    way.update(0)
    way.pipeline.add_fault(noise(0.1))
    assert not measured(noise(0.1), way)[1].is_confirmed


@pytest.mark.parametrize(("deviation", "offset"), [(0.0, 0.7), (0.3, 0.0), (5.0, -3.0), (90.0, 40.0)])
def test_expected_levels_match_simulated_ones(deviation: float, offset: float) -> None:
    levels = Levels(deviation, offset)
    for level in (0, 3, 128, 255):
        picture = np.full((200, 200, 3), level, dtype=np.uint8)
        errors = with_errors(picture, deviation, offset, np.random.default_rng(level)).astype(float) - level
        counts = np.bincount([level], minlength=256)
        for power in (1, 2):
            mean, variance = levels.expected(counts, offset, power)
            values = (errors - offset) ** power
            spread = np.sqrt(variance / values.size)
            assert values.mean() == pytest.approx(mean, abs=5.0 * spread + 1e-9)
            assert values.var() == pytest.approx(variance, rel=0.05, abs=1e-2)


def test_noise_depends_on_the_seed_and_the_tick_only() -> None:
    faults = (noise(0.1), DeadPixels(share=0.5))
    first, again, other = DelayLine(*faults), DelayLine(*faults), DelayLine(*faults, seed=1)
    np.testing.assert_array_equal(first.picture(3), again.picture(3))
    np.testing.assert_array_equal(first.picture(3), first.picture(3))
    assert (first.picture(3) != first.picture(4)).mean() > 0.3
    assert (first.picture(3) != other.picture(3)).mean() > 0.3
    dark = (first.picture(3) == 0).all(axis=2) & (first.picture(4) == 0).all(axis=2)
    assert dark.sum() >= LENS.width * LENS.height // 2


def test_an_area_contains_pixels_by_their_centres() -> None:
    way = DelayLine(DeadArea(left=0.25, top=0.5, right=0.5, bottom=1.0), look=lambda: black() + np.uint8(9))
    rows, columns = np.nonzero((way.picture(0) == 0).all(axis=2))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (16, 31, 12, 23)


def test_a_delayed_camera_keeps_only_needed_images() -> None:
    way = DelayLine(Delay(time=1.0))
    given = []
    for tick in range(200):
        way.update(tick)
        seen = way.pipeline.exposure(tick)
        assert (seen is None) == (way.pipeline.missing(tick) is Missing.DELAYED) == (tick < 50)
        if seen is not None:
            given.append(tick - seen.tick)
    assert (min(given), max(given)) == (50, 54)
    assert len(way.pipeline._in_transit) <= 12
