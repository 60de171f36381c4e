"""Localisation on a known map by an adaptive particle filter: AMCL, with the parameters that it has in Nav2.

Motion: the odometry model of Thrun, Burgard and Fox, Probabilistic Robotics, table 5.6. Measurement: the
likelihood field of table 6.3. AMCL sums the cubes of the beams' likelihoods, which separates good particles from
bad ones only weakly. Here they are multiplied, with an exponent that allows for the dependence of neighbouring
beams. The number of particles follows from their spread (KLD sampling, Fox 2003). The filter uses odometry and
scans only, never the true pose.

A lost robot searches the whole map: with many particles, and nearly uniform weights, so that one scan does not
discard a place. Particles may still gather in a place that only looks alike. So a pose is accepted only if nearly
all beams of the scan end near something on the map, and the scan fits nowhere else as well.
Otherwise, and if the particles do not converge for long, the
search restarts. After the third search, the condition is relaxed each time, because unmapped objects may hide the
map. Random particles while scans fit worse than before (augmented filter, table 8.3) are off unless a robot's
declaration enables them, as in Nav2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Indices, Pose2
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.motion_models import move_anywhere, move_forwards
from sim_nodes.navigation.particles import (
    Estimate,
    adapted_count,
    bins,
    draw,
    estimate,
    occupied,
    particles_needed,
)
from sim_nodes.navigation.place_search import best_places, refined
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

NO_RANGE = 1.0  # [m] of a robot without a lidar; it has no scans
FOUND_DEVIATION = 0.2  # [m]; a search has converged when its particles are this close together
FOUND_SHARE = 0.9  # of the particles that must be
MISFIT_DISTANCE = 0.2  # [m] from everything on the map, beyond which the end of a beam is a misfit
MISFIT_SHARE = 0.02  # of misfit beams that an accepted pose may have
STRICT_SEARCHES = 3  # number of searches after which each one allows twice as many misfits
ASTRAY_SHARE = 0.4  # of misfit beams from which nearby poses are tried
BETTER = 0.5  # maximum ratio of misfits at a nearby pose that is adopted
AROUND = (0.3, 0.3, 0.5)  # standard deviations of nearby poses [m, m, rad]
DISTINCT = 0.02  # difference of the mean log likelihood of beams by which one place is better than another
FREE_STRIDE = 3  # of the free cells that are compared
RIVAL_SPREAD = (0.1, 0.1, 0.05)  # standard deviations of particles at a place that fits better [m, m, rad]
LONGEST_SEARCH = 60  # updates, two turns in place, after which a search restarts


class Localisation(Stateful):
    """The particle filter of one robot.

    Args:
        known: The map.
        declaration: Declaration of the robot's base.
        noise: Source of random numbers.

    Attributes:
        particles: The particles, shape (n, 3).
    """

    STATE = (
        "particles",
        "_odometry",
        "_estimate",
        "_fresh",
        "_lost",
        "_searches",
        "_updates",
        "_fit_slow",
        "_fit_fast",
    )

    DERIVED = ("_offset",)

    def __init__(self, known: NavigationMap, declaration: MobileDeclaration, noise: Noise) -> None:
        self._parameters = declaration.localisation
        self._grid = known.grid
        self._framed = known.grid.framed()
        self._noise = noise
        max_range = NO_RANGE if declaration.lidar is None else declaration.lidar.max_range
        self._log_likelihood = self._likelihood_field(known, max_range)
        self._free = np.argwhere(known.distance >= declaration.radius)
        self._move = move_anywhere if declaration.drive.max_lateral_speed else move_forwards
        self.particles = np.zeros((0, 3))
        self._odometry = Pose2(0.0, 0.0, 0.0)  # at the last update
        self._estimate: Estimate | None = None  # at the last update
        self._fresh = False  # whether there are particles without a measurement update
        self._lost = False  # whether a global search has not converged yet
        self._searches = self._updates = 0  # searches since the robot got lost, updates in the present one
        self._fit_slow = self._fit_fast = 0.0  # slow and fast averages of the fit of scans
        self._offset: tuple[Estimate, Pose2, Pose2] | None = None  # with its inputs
        p = self._parameters
        nearly = p.z_hit * math.exp(-0.5 * (MISFIT_DISTANCE / p.sigma_hit) ** 2) + p.z_rand / max_range
        self._fitting = math.log(nearly)  # minimum of a beam that fits

    def _likelihood_field(self, known: NavigationMap, max_range: float) -> Array:
        p = self._parameters
        # A border of cells far from walls represents everything beyond the map.
        distance = np.pad(known.distance, 1, constant_values=np.inf).clip(max=p.laser_likelihood_max_dist)
        likelihood = p.z_hit * np.exp(-0.5 * (distance / p.sigma_hit) ** 2) + p.z_rand / max_range
        field: Array = np.log(likelihood)
        return field

    # ------------------------------------------------------------ results

    @property
    def running(self) -> bool:
        """Whether updates are of use: an initial pose was set, or a search is active."""
        return len(self.particles) > 0

    @property
    def estimate(self) -> Estimate | None:
        """Estimate of the last update; None before an initial pose and during a search."""
        return None if self._lost else self._estimate

    def pose(self, odometry: Pose2) -> Pose2 | None:
        """Return the pose in `map`: the last estimate advanced by odometry; None without an estimate."""
        offset = self.map_to_odom()
        return None if offset is None else offset.compose(odometry)

    def map_to_odom(self) -> Pose2 | None:
        """Return the pose of `odom` in `map`; None without an estimate."""
        estimate, offset = self.estimate, self._offset
        if estimate is None:
            return None
        if offset is None or offset[0] is not estimate or offset[1] is not self._odometry:
            place = estimate.pose.compose(self._odometry.inverse())
            self._offset = offset = (estimate, self._odometry, place)
        return offset[2]

    # ------------------------------------------------------------ inputs

    def set_initial_pose(self, pose: Pose2, odometry: Pose2, tick: int) -> None:
        """Restart around a pose in `map`, at a pose in `odom`."""
        deviation = np.array(self._parameters.initial_deviation)
        self._fit_slow = self._fit_fast = 0.0
        draws = self._noise.at(tick).standard_normal((self._parameters.max_particles, 3))
        self.particles = np.array(pose) + draws * deviation
        self._odometry, self._estimate, self._fresh = odometry, Estimate(pose, np.diag(deviation**2), 1.0), True
        self._lost = False

    def search(self, odometry: Pose2, tick: int) -> None:
        """Restart with particles all over the free floor; the pose is unknown until they converge."""
        self._odometry, self._estimate, self._fresh, self._lost = odometry, None, True, True
        self._searches = 0
        self._begin_search(self._noise.at(tick))

    def _begin_search(self, random: np.random.Generator) -> None:
        self.particles = self._random_poses(self._parameters.global_particles, random)
        self._searches, self._updates = self._searches + 1, 0
        self._fit_slow = self._fit_fast = 0.0

    def update(self, odometry: Pose2, scan: Scan, tick: int) -> None:
        """Update with a scan, if the robot has moved enough since the last one; requires `running`."""
        assert self.running
        motion = self._odometry.inverse().compose(odometry)
        p = self._parameters
        moved = math.hypot(motion.x, motion.y) >= p.update_min_d or abs(motion.yaw) >= p.update_min_a
        if not (moved or self._fresh):
            return
        self._fresh = False
        random = self._noise.at(tick)
        self._move(self.particles, motion, self._parameters, random)
        self._odometry = odometry
        evidence, beams = self._evidence(scan)
        where = self._resample(evidence, random)
        if p.recovery_alpha_slow:
            self._scatter(evidence, beams, random)
            where = bins(self.particles)
        self._estimate = estimate(self.particles, where)
        if self._lost:
            self._continue_search(self._estimate, scan, random)
        else:
            self._try_nearby_poses(self._estimate, scan, random)

    def _try_nearby_poses(self, believed: Estimate, scan: Scan, random: np.random.Generator) -> None:
        """Adopt a nearby pose where the scan fits much better, if most of it does not fit."""
        misfit = self._misfit(believed.pose, scan)
        if misfit < ASTRAY_SHARE:
            return
        before = self.particles
        spread = random.standard_normal((self._parameters.max_particles, 3)) * np.array(AROUND)
        self.particles = np.array(believed.pose) + spread
        evidence, _ = self._evidence(scan)
        where = self._resample(evidence, random)
        found = estimate(self.particles, where)
        if self._misfit(found.pose, scan) <= BETTER * misfit:
            self._estimate = found
        else:
            self.particles = before

    def _continue_search(self, found: Estimate, scan: Scan, random: np.random.Generator) -> None:
        """Finish the search if it has converged on a valid pose, or restart it."""
        self._updates += 1
        gathered = found.share >= FOUND_SHARE and found.deviation <= FOUND_DEVIATION
        relaxed = 2.0 ** max(0, self._searches - STRICT_SEARCHES)
        if gathered and self._misfit(found.pose, scan) <= MISFIT_SHARE * relaxed:
            self._accept_best_place(found, scan, random)
        elif gathered or self._updates >= LONGEST_SEARCH:
            self._begin_search(random)

    def _accept_best_place(self, found: Estimate, scan: Scan, random: np.random.Generator) -> None:
        """Finish the search, unless the scan fits better or as well in another place of the map.

        The particles move to a place that fits better. If places are alike, the search continues.
        """
        places = best_places(self._grid.points(self._free[::FREE_STRIDE]), scan, self._rate_points)
        here = refined(found.pose, scan, self._rate_points)
        rival = next((place for place in places if not place.is_same(found.pose)), None)
        if rival is None or here.fit >= rival.fit + DISTINCT:
            self._lost = False
        elif rival.fit >= here.fit + DISTINCT:
            spread = random.standard_normal((self._parameters.max_particles, 3)) * np.array(RIVAL_SPREAD)
            self.particles = np.array(rival.pose) + spread

    def _rate_points(self, x: Array, y: Array) -> Array:
        likelihood: Array = self._log_likelihood[self._framed.cells(x, y)]
        return likelihood

    def _misfit(self, pose: Pose2, scan: Scan) -> float:
        """Return the share of beams that do not end near anything on the map, for a pose."""
        bx, by = (scan.x, scan.y) if scan.is_complete else (scan.x[scan.hit], scan.y[scan.hit])
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        cells = self._framed.cells(pose.x + cos * bx - sin * by, pose.y + sin * bx + cos * by)
        misses = self._log_likelihood[cells] < self._fitting
        return int(np.count_nonzero(misses)) / len(misses) if len(misses) else 1.0

    # ------------------------------------------------------------ the filter

    def _random_poses(self, count: int, random: np.random.Generator) -> Array:
        """Draw poses from the free floor."""
        resolution = self._grid.resolution
        cells = self._free[random.integers(len(self._free), size=count)]
        place = self._grid.points(cells) + random.uniform(-0.5, 0.5, (count, 2)) * resolution
        return np.column_stack([place, random.uniform(-math.pi, math.pi, count)])

    def _evidence(self, scan: Scan) -> tuple[Array, int]:
        """Return the log likelihood of evenly spaced beams for each particle, and the number of beams."""
        every = max(1, len(scan.ranges) // self._parameters.max_beams)
        hit = scan.hit[::every]
        bx, by = scan.x[::every][hit], scan.y[::every][hit]
        evidence: Array = self._log_likelihood.take(self._ends(bx, by)).sum(axis=0)
        return evidence, len(bx)

    def _ends(self, bx: Array, by: Array) -> NDArray[np.int32]:
        """Return the cells where beams of particles end, as flat indices, shape (beams, particles).

        Args:
            bx: End points of the beams in the base's frame [m].
            by: See `bx`.
        """
        grid = self._framed
        # In single precision, which is faster, and in units of cells.
        scale = 1.0 / grid.resolution
        x, y, yaw = self.particles.T
        cos, sin = np.cos(yaw).astype(np.float32), np.sin(yaw).astype(np.float32)
        right, up = ((ends[:, None] * scale).astype(np.float32) for ends in (bx, by))
        columns, rows = right * cos, right * sin
        columns -= up * sin
        rows += up * cos
        columns += ((x - grid.x) * scale).astype(np.float32)
        rows += ((y - grid.y) * scale).astype(np.float32)
        cells, inner = columns.astype(np.int32), rows.astype(np.int32)
        # Negative numbers become large ones. On all sides of the map, the border is the same.
        for numbers, count in ((cells, grid.columns), (inner, grid.rows)):
            unsigned = numbers.view(np.uint32)
            if unsigned.max(initial=0) >= count:
                np.minimum(unsigned, np.uint32(count - 1), out=unsigned)
        cells *= grid.rows
        cells += inner
        return cells

    def _resample(self, evidence: Array, random: np.random.Generator) -> Indices:
        """Draw the required number of particles by weight; returns their bins."""
        p = self._parameters
        weights = np.exp((p.global_beam_weight if self._lost else p.beam_weight) * (evidence - evidence.max()))
        weights /= weights.sum()
        where = bins(self.particles)
        chosen = draw(weights, self._needed(where, weights, random), random.random())
        self.particles = self.particles[chosen]
        return where[chosen]

    def _needed(self, where: Indices, weights: Array, random: np.random.Generator) -> int:
        """Return the required number of particles, by the bins of the present ones."""
        p = self._parameters
        most = p.global_particles if self._lost else p.max_particles
        if particles_needed(np.array(float(occupied(where))), p.pf_err, p.pf_z) <= p.min_particles:
            return p.min_particles
        drawn = where[random.choice(len(weights), most, p=weights)]
        return adapted_count(drawn, p.min_particles, most, p.pf_err, p.pf_z)

    def _scatter(self, evidence: Array, beams: int, random: np.random.Generator) -> None:
        """Replace some particles by random ones, the more the worse scans fit now than on average."""
        p = self._parameters
        if beams == 0:
            return
        fit = float(np.exp(evidence / beams).mean())
        self._fit_slow += (p.recovery_alpha_slow if self._fit_slow else 1.0) * (fit - self._fit_slow)
        self._fit_fast += (p.recovery_alpha_fast if self._fit_fast else 1.0) * (fit - self._fit_fast)
        share = max(0.0, 1.0 - self._fit_fast / self._fit_slow)
        chosen = random.random(len(self.particles)) < share
        self.particles[chosen] = self._random_poses(int(chosen.sum()), random)
