"""Checks confirm effects of faults; faults without an effect, or with another one, are not confirmed."""

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
from sim_nodes.faults.statistics import truncated
from tests.sim_nodes.faults.ruler import Ruler, measured, pipeline

LENGTH, ANGLE = Quantity.LENGTH, Quantity.ANGLE
PATIENCE = 1500  # ticks; sufficient for every check


def noise(length: float = 0.0, angle: float = 0.0) -> GaussianNoise:
    return GaussianNoise(deviation={LENGTH: length, ANGLE: angle})


def bias(length: float = 0.0, angle: float = 0.0) -> Bias:
    return Bias(offset={LENGTH: length, ANGLE: angle})


FAULTS: tuple[SensorFault, ...] = (
    noise(0.001),
    noise(0.3),
    noise(5.0),
    noise(0.2, 0.05),
    bias(0.05),
    bias(-0.8, 0.3),
    BeamLoss(share=0.02),
    BeamLoss(share=0.4),
    BeamLoss(share=1.0),
    DeadSector(start=-0.5, end=0.5),
    DeadBeams(beams=(3, 5)),
    MessageLoss(probability=0.2),
    MessageLoss(probability=1.0),
    Freeze(),
    Delay(time=0.3),
    PowerLoss(),
)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_fault_is_found(fault: SensorFault, seed: int) -> None:
    ticks, check = measured(fault, declared=(fault,), way=pipeline(fault, seed=seed), ticks=PATIENCE)
    assert check.is_confirmed, check.summary()
    assert ticks < 400


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_sound_sensor_has_no_fault(fault: SensorFault) -> None:
    _, check = measured(fault, declared=(fault,), way=pipeline(), ticks=PATIENCE)
    assert not check.is_confirmed, check.summary()
    assert check.summary()


@pytest.mark.parametrize(
    ("fault", "instead"),
    [
        (noise(0.2), noise(0.12)),
        (noise(0.2), noise(0.3)),
        (noise(0.2), bias(0.2)),
        (noise(0.2, 0.05), noise(0.2)),
        (bias(0.2), bias(0.1)),
        (bias(0.2), bias(-0.2)),
        (bias(0.2), noise(0.2)),
        (BeamLoss(share=0.4), BeamLoss(share=0.15)),
        (BeamLoss(share=0.1), BeamLoss(share=0.3)),
        (DeadBeams(beams=(3, 5)), DeadBeams(beams=(3,))),
        (MessageLoss(probability=0.7), MessageLoss(probability=0.1)),
        (MessageLoss(probability=1.0), MessageLoss(probability=0.8)),
        (Freeze(), Delay(time=0.3)),
        (Delay(time=0.3), Delay(time=0.2)),
        (Delay(time=0.3), Delay(time=0.4)),
        (PowerLoss(), MessageLoss(probability=0.5)),
    ],
    ids=str,
)
def test_a_check_does_not_confirm_another_fault(fault: SensorFault, instead: SensorFault) -> None:
    _, check = measured(fault, declared=(fault,), way=pipeline(instead), ticks=PATIENCE)
    assert not check.is_confirmed, check.summary()


@pytest.mark.parametrize(
    ("fault", "others"),
    [
        (noise(0.5), (bias(0.4), BeamLoss(share=0.5), Delay(time=0.2), MessageLoss(probability=0.3))),
        (bias(0.4), (noise(0.5), DeadBeams(beams=(1, 2)))),
        (BeamLoss(share=0.3), (noise(1.0), bias(-0.5), DeadSector(start=0.0, end=1.0))),
        (MessageLoss(probability=0.3), (Delay(time=0.5), noise(0.1))),
        (Freeze(), (noise(0.1), MessageLoss(probability=0.3))),
        (Delay(time=0.3), (MessageLoss(probability=0.3), Freeze())),
    ],
    ids=str,
)
def test_a_fault_is_found_among_others(fault: SensorFault, others: tuple[SensorFault, ...]) -> None:
    _, check = measured(fault, declared=(fault, *others), way=pipeline(fault, *others), ticks=PATIENCE)
    assert check.is_confirmed, check.summary()


def test_faults_without_an_effect_are_not_confirmed() -> None:
    blind = DeadBeams(beams=(0, 10))  # beams without a return
    _, check = measured(blind, declared=(blind,), way=pipeline(blind), ticks=PATIENCE)
    assert not check.is_confirmed


def test_a_constant_reading_does_not_confirm_a_freeze() -> None:
    class Still(Ruler):
        def read(self, tick: int):  # type: ignore[no-untyped-def]
            return super().read(0)

    way = pipeline(Freeze())
    way.sensor = Still()
    _, check = measured(Freeze(), declared=(Freeze(),), way=way, ticks=PATIENCE)
    assert not check.is_confirmed


@pytest.mark.parametrize(("low", "high"), [(-np.inf, np.inf), (-1.0, 2.0), (-np.inf, 0.3), (1.5, 8.0)])
def test_moments_of_truncated_normal_errors_are_those_of_their_density(low: float, high: float) -> None:
    x = np.linspace(max(low, -12.0), min(high, 12.0), 200_001)
    density = np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)
    share = np.trapezoid(density, x)
    found = truncated(np.array([low]), np.array([high]))
    assert found.share[0] == pytest.approx(share, rel=1e-6)
    for moment, power in ((found.first, 1), (found.second, 2), (found.fourth, 4)):
        assert moment[0] == pytest.approx(np.trapezoid(density * x**power, x) / share, rel=1e-5, abs=1e-9)
