from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.navigation.particles import adapted_count, bins, draw, estimate, particles_needed


def test_the_number_of_particles_follows_the_formula() -> None:
    # Worked out by hand for 101 bins, 0.05 and 0.99: 1000 (1 - 0.00222 + 0.0471 * 0.99)^3
    assert float(particles_needed(np.array(101.0), 0.05, 0.99)) == pytest.approx(1139.4, rel=1e-3)
    numbers = particles_needed(np.arange(1.0, 500.0), 0.05, 0.99)
    assert bool((np.diff(numbers) >= 0.0).all())


def test_spread_particles_require_more_particles() -> None:
    random = np.random.default_rng(0)
    together = bins(random.normal(0.0, 0.02, (5000, 3)) + 0.1)
    apart = bins(random.uniform(-5.0, 5.0, (5000, 3)))
    assert adapted_count(together, 100, 5000, 0.05, 0.99) == 100
    assert adapted_count(apart, 100, 5000, 0.05, 0.99) == 5000
    halfway = bins(random.uniform(-0.9, 0.9, (5000, 3)))
    assert 100 < adapted_count(halfway, 100, 5000, 0.05, 0.99) < 5000


def test_bins_wrap_headings() -> None:
    poses = np.array([[0.1, 0.1, 0.01], [0.4, 0.4, 0.1], [0.6, 0.1, 0.01], [0.1, 0.1, 0.01 + 2 * math.pi]])
    first, same, beside, around = bins(poses).tolist()
    assert first == same == around
    assert beside != first
    assert len(set(bins(np.array([[0.0, 0.0, math.radians(5 + 10 * i)] for i in range(36)])).tolist())) == 36


def test_particles_are_drawn_by_their_weights() -> None:
    weights = np.array([0.5, 0.0, 0.3, 0.2])
    counts = np.bincount(draw(weights, 1000, 0.37), minlength=4)
    assert counts.tolist() == pytest.approx([500, 0, 300, 200], abs=1)


def test_the_estimate_is_the_densest_place_not_a_mean_of_two() -> None:
    random = np.random.default_rng(1)
    here = np.array([2.2, 1.2, math.pi]) + random.normal(0.0, 0.05, (700, 3))
    there = np.array([-3.0, 0.0, 0.0]) + random.normal(0.0, 0.05, (300, 3))
    particles = np.concatenate([there, here])
    found = estimate(particles, bins(particles))
    assert found.pose.distance(2.2, 1.2) < 0.02
    assert abs(found.pose.yaw) == pytest.approx(math.pi, abs=0.02)
    assert found.share == pytest.approx(0.7)
    assert found.deviation == pytest.approx(0.05 * math.sqrt(2.0), rel=0.1)
    assert float(found.covariance[2, 2]) == pytest.approx(0.05**2, rel=0.2)
