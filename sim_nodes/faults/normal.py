"""What of normally distributed errors is left when a sensor gives no values beyond its limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_nodes.geometry import Array

FAR = 40.0  # standard deviations that are as good as infinitely many


@dataclass(frozen=True)
class Truncated:
    """Moments of normal distributions, each cut off at two values of its own, about the mean before that.

    Standard formulas of the truncated normal distribution, in standard deviations; arrays of shape (n,).
    """

    share: Array  # that is left
    first: Array  # mean
    second: Array  # mean of the squares
    fourth: Array


def truncated(low: Array, high: Array) -> Truncated:
    """Moments of standard normal distributions without what is below `low` and above `high`."""
    from scipy.special import ndtr  # noqa: PLC0415 - slow to load, and seldom needed

    a, b = np.clip(low, -FAR, FAR), np.clip(high, -FAR, FAR)
    share = ndtr(b) - ndtr(a)
    at_a, at_b = _density(a), _density(b)
    with np.errstate(divide="ignore", invalid="ignore"):  # where nothing is left, nothing will be looked at
        return Truncated(
            share,
            (at_a - at_b) / share,
            1.0 + (a * at_a - b * at_b) / share,
            3.0 + ((a**3 + 3.0 * a) * at_a - (b**3 + 3.0 * b) * at_b) / share,
        )


def _density(x: Array) -> Array:
    density: Array = np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi)
    return density
