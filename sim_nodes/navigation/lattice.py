"""Search for a path over poses, in the manner of hybrid A*, for robots whose heading matters.

D. Dolgov, S. Thrun, M. Montemerlo, J. Diebel (2010): "Path planning for autonomous vehicles in unknown
semi-structured environments". Poses are continuous; each cell of position and heading keeps the cheapest.
Poses with the least estimated cost are expanded together, so that numpy works on many. In each round, the most
promising ones are connected with the goal. The estimate is the cost of a path of the core over cells of the map.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices, wrap
from sim_nodes.navigation.cover import Cover
from sim_nodes.navigation.maps import Grid
from sim_nodes.navigation.mobility import Mobility
from sim_nodes.navigation.planner import ESCAPE_RADIUS, inflation
from sim_nodes.robots.navigation import NavigationDeclaration

CELL = 0.1  # [m]
HEADINGS = 72
BATCH = 192  # poses expanded at once
WEIGHT = 1.2  # of the estimate, which speeds up the search
WIDTH = 0.15  # [m] of estimated cost within which poses are expanded at once
SHOTS = 12  # poses per round that are connected with the goal
SLACK, EXTRA = 1.1, 0.3  # factor and cost [m] by which a found path may exceed the estimate
ESCAPE_FACTOR = 10.0  # of the cost of poses too close to an obstacle, around a robot that is so already
NEARBY = 0.6  # [m] around start and goal where poses may be as close to obstacles as the margin allows
TIGHT, TIGHT_COST = 0.03, 3.0  # gap [m] at which further costs have fallen to a third; these costs without a gap
TOO_CLOSE = 0.02  # [m] by which such a robot may come closer, because cells are a sample


@dataclass(frozen=True)
class Floor:
    """The floor as seen by a search.

    Attributes:
        grid: Grid of the map.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        cover: Cover of the robot.
        parameters: Cost near obstacles.
        start: Pose of the robot (x, y, yaw), shape (3,).
        goal: See `start`.
        start_gap: Gap of the start to obstacles [m]; it may be negative.
        goal_gap: The same of the goal.
        spare: Further gap that poses keep beyond `NEARBY` of start and goal [m].
    """

    grid: Grid
    distance: Array
    cover: Cover
    parameters: NavigationDeclaration
    start: Array
    goal: Array
    start_gap: float
    goal_gap: float
    spare: float

    def factors(self, poses: Array) -> Array:
        """Return the relative costs of poses: the mean over the discs, infinite without room, shape (n,)."""
        cover = self.cover
        room = self.grid.interpolate(self.distance, poses[:, 0], poses[:, 1]) - cover.reach
        factors = np.ones(len(poses))
        near = np.flatnonzero(room < self.parameters.inflation_radius)
        gaps = cover.disc_gaps(self.grid, self.distance, poses[near])
        least = gaps.min(axis=1)
        factors[near] = inflation(gaps, self.parameters).mean(axis=1)
        factors[near] += TIGHT_COST * np.exp(np.minimum(-least / TIGHT, 0.0))
        factors[near[least < 0.0]] = np.inf
        factors[near[self._is_tight(poses[near], least)]] = np.inf
        if self.start_gap < 0.0:
            leaves = (least < 0.0) & (least >= self.start_gap - TOO_CLOSE)
            factors[near[leaves & (_away(poses[near], self.start) < ESCAPE_RADIUS)]] = ESCAPE_FACTOR
        return factors

    def _is_tight(self, poses: Array, gaps: Array) -> NDArray[np.bool_]:
        """Whether poses lack the spare gap, and are not close to an end that lacks it."""
        tight: NDArray[np.bool_] = gaps < self.spare
        for end, gap in ((self.start, self.start_gap), (self.goal, self.goal_gap)):
            if gap < self.spare + TOO_CLOSE:
                tight &= _away(poses, end) > NEARBY
        return tight


def _away(poses: Array, end: Array) -> Array:
    away: Array = np.hypot(poses[:, 0] - end[0], poses[:, 1] - end[1])
    return away


class Search:
    """One search.

    Args:
        mobility: Motions of the robot.
        floor: The floor.
        to_go: Cost of a path of the core from each cell to the goal [m], infinite without one.
        change_penalty: Cost of a change between forwards and backwards [m].
        most_poses: Number of poses after which it gives up.
    """

    def __init__(
        self, mobility: Mobility, floor: Floor, to_go: Array, change_penalty: float, most_poses: int
    ) -> None:
        self._mobility = mobility
        self._floor = floor
        self._to_go = to_go
        self._change_penalty = change_penalty
        self._most_poses = most_poses
        grid = floor.grid
        size = math.ceil(grid.columns * grid.resolution / CELL), math.ceil(grid.rows * grid.resolution / CELL)
        self._shape = (*size, HEADINGS)
        self._owners: Indices = np.zeros(math.prod(self._shape), dtype=np.int64)  # pose of each cell, plus 1

    def run(self, start: Array, goal: Array) -> Array | None:
        """Return the poses of a path, shape (n, 3); None without one.

        Args:
            start: Pose (x, y, yaw), shape (3,).
            goal: See `start`.
        """
        self._poses, self._costs = start[None], np.zeros(1)
        self._parents: Indices = np.full(1, -1)
        self._motions: Indices = np.full(1, -1)
        estimates = self._estimates(self._poses)
        waiting: Indices = np.zeros(1, dtype=np.int64)
        self._owners[self._cells(self._poses)] = 1
        best: tuple[float, int, Array] | None = None
        while len(waiting) and len(self._poses) < self._most_poses:
            totals = self._costs[waiting] + WEIGHT * estimates[waiting]
            least = float(totals.min())
            if not math.isfinite(least) or (best is not None and best[0] <= SLACK * least + EXTRA):
                break
            chosen = np.argsort(totals, kind="stable")[:BATCH]
            chosen = chosen[totals[chosen] <= least + WIDTH]
            batch = waiting[chosen]
            waiting = np.delete(waiting, chosen)
            batch = batch[self._owners[self._cells(self._poses[batch])] == batch + 1]
            if len(batch) == 0:
                continue
            best = self._shoot(batch, estimates, goal, best)
            added = self._expand(batch)
            estimates = np.append(estimates, self._estimates(self._poses[added]))
            waiting = np.append(waiting, added)
        return None if best is None else np.vstack([*self._back(best[1]), best[2]])

    def _estimates(self, poses: Array) -> Array:
        cores = self._floor.cover.cores(poses)
        estimates: Array = self._to_go[self._floor.grid.cells(*cores.T)]
        return estimates

    def _cells(self, poses: Array) -> Indices:
        """Return the cells of position and heading, as flat indices."""
        grid = self._floor.grid
        columns = ((poses[:, 0] - grid.x) / CELL).astype(np.int64).clip(0, self._shape[0] - 1)
        rows = ((poses[:, 1] - grid.y) / CELL).astype(np.int64).clip(0, self._shape[1] - 1)
        headings = np.rint(poses[:, 2] * (HEADINGS / (2.0 * np.pi))).astype(np.int64) % HEADINGS
        cells: Indices = (columns * self._shape[1] + rows) * HEADINGS + headings
        return cells

    def _shoot(
        self, batch: Indices, estimates: Array, goal: Array, best: tuple[float, int, Array] | None
    ) -> tuple[float, int, Array] | None:
        """Connect poses with the goal; returns the best path: cost, last pose of the search, and the rest."""
        nearest = batch[np.argsort(estimates[batch], kind="stable")[:SHOTS]]
        totals = self._costs[nearest] + self._mobility.costs(relative(self._poses[nearest], goal))
        for at in np.argsort(totals, kind="stable"):
            if best is not None and totals[at] >= best[0]:
                break
            pose = int(nearest[at])
            rest = connect(self._mobility, self._poses[pose], goal)
            factors = self._floor.factors(rest)
            if np.isfinite(factors).all():
                total = float(self._costs[pose] + (totals[at] - self._costs[pose]) * factors.mean())
                if best is None or total < best[0]:
                    best = total, pose, rest
                break
        return best

    def _expand(self, batch: Indices) -> Indices:
        """Add the poses that motions lead to, where they are cheaper; returns their indices."""
        motions = self._mobility.motions
        ends = placed(self._poses[batch], motions.samples)
        count, samples = len(motions.costs), motions.samples.shape[1]
        factors = self._floor.factors(ends.reshape(-1, 3)).reshape(len(batch), count, samples).mean(axis=2)
        ways = motions.ways
        before = np.where(self._motions[batch] < 0, 0.0, ways[self._motions[batch]])
        changes = before[:, None] * ways < 0.0
        costs = self._costs[batch][:, None] + motions.costs * factors + self._change_penalty * changes
        parents, motion = np.repeat(batch, count), np.tile(np.arange(count), len(batch))
        poses, costs = ends[:, :, -1].reshape(-1, 3), costs.ravel()
        cells = self._cells(poses)
        owners = self._owners[cells]
        cheaper = np.isfinite(costs) & ((owners == 0) | (costs < self._costs[owners - 1] - 1e-9))
        order = np.lexsort((costs, cells))
        order = order[cheaper[order]]
        first = np.ones(len(order), dtype=np.bool_)
        first[1:] = cells[order][1:] != cells[order][:-1]
        kept = order[first]
        added: Indices = np.arange(len(self._poses), len(self._poses) + len(kept))
        self._owners[cells[kept]] = added + 1
        self._poses = np.vstack([self._poses, poses[kept]])
        self._costs = np.append(self._costs, costs[kept])
        self._parents = np.append(self._parents, parents[kept])
        self._motions = np.append(self._motions, motion[kept])
        return added

    def _back(self, last: int) -> list[Array]:
        """Return the poses from the start to a pose, with those along the motions."""
        pieces: list[Array] = []
        while self._parents[last] >= 0:
            parent = int(self._parents[last])
            samples = self._mobility.motions.samples[self._motions[last]]
            pieces.append(placed(self._poses[parent][None], samples[None])[0, 0])
            last = parent
        return [self._poses[:1], *pieces[::-1]]


def relative(starts: Array, ends: Array) -> Array:
    """Return poses in the frames of others; shapes (..., 3) broadcast."""
    (x, y, yaw), (to_x, to_y, to_yaw) = np.moveaxis(starts, -1, 0), np.moveaxis(ends, -1, 0)
    cos, sin, dx, dy = np.cos(yaw), np.sin(yaw), to_x - x, to_y - y
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap(to_yaw - yaw)], axis=-1)


def placed(poses: Array, samples: Array) -> Array:
    """Return relative poses (m, k, 3) at each of some poses (n, 3), shape (n, m, k, 3)."""
    cos, sin = np.cos(poses[:, 2])[:, None, None], np.sin(poses[:, 2])[:, None, None]
    x, y, turn = samples[..., 0], samples[..., 1], samples[..., 2]
    base = poses[:, None, None, :]
    return np.stack(
        [base[..., 0] + cos * x - sin * y, base[..., 1] + sin * x + cos * y, base[..., 2] + turn], axis=-1
    )


def connect(mobility: Mobility, start: Array, end: Array) -> Array:
    """Return the poses of the connection of two poses, without the first one, shape (k, 3)."""
    rest = mobility.connection(relative(start, end))
    found = placed(start[None], rest[None])[0, 0]
    found[-1] = end
    connection: Array = found
    return connection
