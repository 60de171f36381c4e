"""Localisation on a known map by a particle filter, with the parameters of Nav2's AMCL under their names there.

Motion: the odometry model of Thrun, Burgard and Fox, Probabilistic Robotics, table 5.6. Measurement: the
likelihood field of table 6.3. AMCL sums the cubes of the beams' likelihoods, which tells good particles from bad
ones only weakly; here they are multiplied, with an exponent that allows for neighbouring beams not being
independent. The true pose never enters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.navigation.grid import NavigationMap
from sim_nodes.noise import Noise
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful


@dataclass(frozen=True)
class LocalisationParameters:
    """Parameters under their names in Nav2's AMCL."""

    max_particles: int = 400
    max_beams: int = 60
    alpha1: float = 0.1  # error of rotation from rotation
    alpha2: float = 0.1  # error of rotation from translation
    alpha3: float = 0.1  # error of translation from translation
    alpha4: float = 0.1  # error of translation from rotation
    sigma_hit: float = 0.1  # [m]
    z_hit: float = 0.5
    z_rand: float = 0.5
    laser_likelihood_max_dist: float = 1.0  # [m]
    beam_weight: float = 0.2  # what a beam counts, compared with an independent measurement; not in AMCL
    update_min_d: float = 0.1  # [m]
    update_min_a: float = 0.1  # [rad]
    initial_deviation: tuple[float, float, float] = (0.1, 0.1, 0.05)  # [m, m, rad] about a given initial pose


class Localisation(Stateful):
    """The filter of one robot.

    Args:
        known: The map.
        max_range: Range of the lidar [m].
        noise: Source of its random numbers.
    """

    STATE = ("_particles", "_odometry", "_estimate", "_fresh")

    def __init__(
        self,
        known: NavigationMap,
        max_range: float,
        noise: Noise,
        parameters: LocalisationParameters | None = None,
    ) -> None:
        self._parameters = parameters or LocalisationParameters()
        self._grid = known.grid
        self._noise = noise
        self._log_likelihood = self._likelihood_field(known, max_range)
        self._particles = np.zeros((0, 3))
        self._odometry = Pose2(0.0, 0.0, 0.0)  # at the last update
        self._estimate: Pose2 | None = None  # at the last update
        self._fresh = False  # an initial pose has been given that no scan has been held against

    def _likelihood_field(self, known: NavigationMap, max_range: float) -> Array:
        p = self._parameters
        distance = np.minimum(known.distance, p.laser_likelihood_max_dist)
        likelihood = p.z_hit * np.exp(-0.5 * (distance / p.sigma_hit) ** 2) + p.z_rand / max_range
        field: Array = p.beam_weight * np.log(likelihood)
        return field

    def set_initial_pose(self, pose: Pose2, odometry: Pose2, tick: int) -> None:
        """Start over about a pose in the map, at a pose in `odom`."""
        draws = self._noise.at(tick).standard_normal((self._parameters.max_particles, 3))
        self._particles = np.array(pose) + draws * np.array(self._parameters.initial_deviation)
        self._odometry, self._estimate, self._fresh = odometry, pose, True

    def pose(self, odometry: Pose2) -> Pose2 | None:
        """The pose in the map: the last estimate carried on by odometry; None without an initial pose."""
        offset = self.map_to_odom()
        return None if offset is None else offset.compose(odometry)

    def map_to_odom(self) -> Pose2 | None:
        """The pose of `odom` in the map; None without an initial pose."""
        return None if self._estimate is None else self._estimate.compose(self._odometry.inverse())

    def update(self, odometry: Pose2, scan: Scan, tick: int) -> Pose2:
        """Take in a scan, if the robot has moved enough since the last one; returns the pose.

        There has to be an initial pose.
        """
        assert self._estimate is not None
        motion = self._odometry.inverse().compose(odometry)
        p = self._parameters
        moved = math.hypot(motion.x, motion.y) >= p.update_min_d or abs(motion.yaw) >= p.update_min_a
        if not (moved or self._fresh):
            return self._estimate.compose(motion)
        self._fresh = False
        random = self._noise.at(tick)
        self._move(motion, random)
        self._odometry = odometry
        self._resample(self._weights(scan), random.random())
        self._estimate = self._mean()
        return self._estimate

    def _mean(self) -> Pose2:
        x, y, _ = self._particles.mean(axis=0).tolist()
        sin, cos = np.sin(self._particles[:, 2]).mean(), np.cos(self._particles[:, 2]).mean()
        return Pose2(x, y, math.atan2(sin, cos))

    def _move(self, motion: Pose2, random: np.random.Generator) -> None:
        p, particles = self._parameters, self._particles
        way = math.hypot(motion.x, motion.y)
        first = math.atan2(motion.y, motion.x) if way > 0.01 else 0.0
        second = wrap(motion.yaw - first)
        # Driving backwards is not a half turn, a drive and a half turn.
        turn1 = min(abs(first), math.pi - abs(first))
        turn2 = min(abs(second), math.pi - abs(second))
        noise = random.standard_normal((3, len(particles)))
        rotation1 = first + noise[0] * math.sqrt(p.alpha1 * turn1**2 + p.alpha2 * way**2)
        distance = way + noise[1] * math.sqrt(p.alpha3 * way**2 + p.alpha4 * (turn1**2 + turn2**2))
        rotation2 = second + noise[2] * math.sqrt(p.alpha1 * turn2**2 + p.alpha2 * way**2)
        heading = particles[:, 2] + rotation1
        particles[:, 0] += distance * np.cos(heading)
        particles[:, 1] += distance * np.sin(heading)
        particles[:, 2] = heading + rotation2

    def _weights(self, scan: Scan) -> Array:
        """Weights of the particles by evenly spread beams, shape (particles,)."""
        every = max(1, len(scan.ranges) // self._parameters.max_beams)
        hit = scan.hit[::every]
        bx, by = scan.x[::every][hit], scan.y[::every][hit]
        x, y, yaw = (column[:, None] for column in self._particles.T)
        cos, sin = np.cos(yaw), np.sin(yaw)
        cells = self._grid.cells(x + cos * bx - sin * by, y + sin * bx + cos * by)
        evidence = self._log_likelihood[cells].sum(axis=1)
        weights = np.exp(evidence - evidence.max())
        normalised: Array = weights / weights.sum()
        return normalised

    def _resample(self, weights: Array, offset: float) -> None:
        """Draw particles by weight, with one random number for all (low variance, table 4.4)."""
        count = len(weights)
        chosen = np.searchsorted(np.cumsum(weights), (offset + np.arange(count)) / count)
        self._particles = self._particles[chosen.clip(0, count - 1)]
