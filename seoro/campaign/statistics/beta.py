"""Beta distribution: its distribution function and quantiles."""

from __future__ import annotations

import math
from typing import Final

_MOST: Final = 100_000  # terms of the fraction; about the root of the larger parameter are needed
_STEPS: Final = 60  # bisections; each halves the error
_ACCURACY: Final = 1e-15
_TINY: Final = 1e-300


def log_beta(a: float, b: float) -> float:
    """Return the logarithm of the beta function of positive numbers."""
    return math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)


def log_choose(total: int, chosen: int) -> float:
    """Return the logarithm of a binomial coefficient."""
    return math.lgamma(total + 1) - math.lgamma(chosen + 1) - math.lgamma(total - chosen + 1)


def beta_cdf(x: float, a: float, b: float) -> float:
    """Return the regularised incomplete beta function, the distribution function of Beta(a, b).

    The continued fraction is formula 8.17.22 of the NIST Digital Library of Mathematical Functions, evaluated by
    the modified method of Lentz.

    Args:
        x: Argument, from 0 to 1.
        a, b: Parameters, positive.
    """
    if x <= 0.0 or x >= 1.0:
        return 0.0 if x <= 0.0 else 1.0
    if x > (a + 1.0) / (a + b + 2.0):  # the fraction converges slowly there
        return 1.0 - beta_cdf(1.0 - x, b, a)
    scale = a * math.log(x) + b * math.log1p(-x) - log_beta(a, b)
    return math.exp(scale) / a / _denominator(x, a, b)


def _denominator(x: float, a: float, b: float) -> float:
    """Return the continued fraction 1 + d1 / (1 + d2 / (1 + ...))."""
    value, numerator, denominator = 1.0, 1.0, 0.0
    for term in range(1, _MOST):
        m = term // 2
        if term % 2:
            d = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0))
        else:
            d = m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m))
        denominator = 1.0 / (_nonzero(1.0 + d * denominator))
        numerator = _nonzero(1.0 + d / numerator)
        factor = numerator * denominator
        value *= factor
        if abs(factor - 1.0) < _ACCURACY:
            break
    return value


def _nonzero(value: float) -> float:
    return value if abs(value) > _TINY else _TINY


def beta_quantile(share: float, a: float, b: float) -> float:
    """Return the quantile of Beta(a, b), by bisection.

    Args:
        share: Probability below the quantile, from 0 to 1.
        a, b: Parameters, positive.
    """
    low, high = 0.0, 1.0
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        if beta_cdf(middle, a, b) < share:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0
