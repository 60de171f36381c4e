"""Inverse kinematics: damped least squares from one or several starts.

Own code, because engines differ in theirs or have none. Steps follow Levenberg and Marquardt; joints are clipped
at their limits. The solution depends on the start: a search from the present configuration stays on its branch.

If the first starts fail, many more are tried: for arms of seven joints with narrow limits, one start in ten leads
to a solution. These searches hold joints at the limits that they push against, and move the others, as an active
set of constraints does. Otherwise postures with three joints near limits are hardly found. The last starts are the
nearest of a table of postures by the pose of the tool. Poses beyond the stretched arm are not searched.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache

import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.manipulation.chain import Chain, Flags
from sim_nodes.noise import Noise

POSITION_TOLERANCE = 1e-6  # [m]
ANGLE_TOLERANCE = 1e-6  # [rad]
MAX_ITERATIONS = 60
MAX_STEP = 0.5  # [rad], [m] of a joint per iteration
MIN_DAMPING, MAX_DAMPING = 1e-6, 1e3
STARTS = 16  # random starts beside the given ones
MORE_STARTS, BATCH = 512, 128  # further starts if those fail, and their batch size
POSTURES, NEAREST = 4096, 128  # of the table of each arm, and how many of them are tried
HOLDS = 3  # rounds in which joints are held at their limits
LEVER = 0.3  # [m] that a turn of 1 rad counts as far as, in the distance of poses
HALF_TURN = 1e-6  # sine of an angle at which a rotation is near none or half a turn
NEAR = 1e-2  # [m], [rad] error from which a search reaches a solution
EXACT = 5e-7  # [m], [rad] error of each component, within the tolerances
SAME = 1e-3  # [rad], [m] distance below which solutions are the same


def solve(chain: Chain, target: Array, start: Array) -> Array | None:
    """Search the configuration at which the tool has a pose, from a start.

    Args:
        chain: The arm.
        target: Pose of the tool in the base, shape (4, 4).
        start: Configuration within the limits.

    Returns:
        Configuration within the limits; None if the search fails.
    """
    configuration, damping = start, 1e-3
    pose, jacobian = chain.jacobian(configuration)
    error = _error(pose, target)
    for _ in range(MAX_ITERATIONS):
        if _is_small(error):
            return configuration
        step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping * np.eye(6), error)
        step *= min(1.0, MAX_STEP / max(float(np.abs(step).max()), 1e-12))
        tried = np.clip(configuration + step, chain.limits.lower, chain.limits.upper)
        tried_pose, tried_jacobian = chain.jacobian(tried)
        tried_error = _error(tried_pose, target)
        if tried_error @ tried_error < error @ error:
            configuration, jacobian, error = tried, tried_jacobian, tried_error
            damping = max(damping / 10.0, MIN_DAMPING)
        else:
            damping *= 10.0
            if damping > MAX_DAMPING:
                return None
    return None


def solutions(chain: Chain, target: Array, start: Array, home: Array, noise: Noise) -> Iterator[Array]:
    """Yield configurations at which the tool has a pose: that found from `start`, then others, nearest first.

    None for a pose beyond the stretched arm.

    Args:
        chain: The arm.
        target: Pose of the tool in the base, shape (4, 4).
        start: Present configuration.
        home: Preferred posture.
        noise: Source of further starts.
    """
    if out_of_reach(chain, target) > 0.0:
        return
    first = solve(chain, target, start)
    found = [] if first is None else [nearest_turns(chain, first, start)]
    yield from found
    lower, upper = _within_turn(chain, ~chain.limits.slides)
    drawn = noise.at(0).uniform(lower, upper, size=(STARTS, len(start)))
    others = _solve_from(chain, target, start, (home, *drawn), found)
    if not found and not others:
        others = _search(chain, target, start, noise)
    yield from sorted(others, key=lambda configuration: float(np.abs(configuration - start).max()))


def _solve_from(
    chain: Chain, target: Array, start: Array, starts: Iterable[Array], found: Sequence[Array] = ()
) -> list[Array]:
    """Return the solutions from several starts that differ from each other and from those found, near `start`."""
    solved = (solve(chain, target, begin) for begin in starts)
    return _distinct(chain, (solution for solution in solved if solution is not None), start, found)


def _distinct(chain: Chain, solved: Iterable[Array], start: Array, found: Sequence[Array] = ()) -> list[Array]:
    """Return the solutions that differ from each other and from those found, near `start`."""
    others: list[Array] = []
    for solution in solved:
        near = nearest_turns(chain, solution, start)
        if all(np.abs(near - other).max() > SAME for other in (*found, *others)):
            others.append(near)
    return others


def out_of_reach(chain: Chain, target: Array) -> float:
    """Return the distance of a pose beyond the stretched arm [m]; 0 if the pose may be reachable."""
    return max(0.0, float(np.linalg.norm(target[:3, 3] - chain.shoulder)) - chain.reach)


def _search(chain: Chain, target: Array, start: Array, noise: Noise) -> list[Array]:
    """Return solutions from many starts: those of the first batch with any."""
    lower, upper = _postures_within(chain)
    for batch in range(MORE_STARTS // BATCH):
        drawn = noise.at(batch + 1).uniform(lower, upper, size=(BATCH, len(start)))
        found = _distinct(chain, _solve_all(chain, target, drawn), start)
        if found:
            return found
    return _distinct(chain, _solve_all(chain, target, _nearest_postures(chain, target)), start)


def _solve_all(chain: Chain, target: Array, starts: Array) -> Array:
    """Return the solutions that searches from many starts reach, shape (m, n)."""
    return _approach(chain, target, _approach(chain, target, starts, NEAR), EXACT)


def _postures_within(chain: Chain) -> tuple[Array, Array]:
    """Return lower and upper positions of the joints between which all postures are, each of shape (n,)."""
    # A joint with less than a full turn keeps its range, because no other position is the same posture.
    return _within_turn(chain, ~chain.limits.slides & (chain.limits.upper - chain.limits.lower >= 2.0 * math.pi))


def _within_turn(chain: Chain, joints: Flags) -> tuple[Array, Array]:
    """Return the limits of all joints, those of some reduced to half a turn to each side."""
    lower = np.where(joints, np.maximum(chain.limits.lower, -math.pi), chain.limits.lower)
    upper = np.where(joints, np.minimum(chain.limits.upper, math.pi), chain.limits.upper)
    return lower, upper


@lru_cache(maxsize=8)
def _posture_table(chain: Chain) -> tuple[Array, Array]:
    """Return random postures, shape (m, n), and the poses of the tool, shape (m, 4, 4)."""
    lower, upper = _postures_within(chain)
    postures = Noise(0, "postures").at(0).uniform(lower, upper, size=(POSTURES, len(lower)))
    return postures, chain.jacobians(postures)[0]


def _nearest_postures(chain: Chain, target: Array) -> Array:
    """Return the postures of the table with the nearest poses of the tool, shape (m, n)."""
    postures, poses = _posture_table(chain)
    errors = _errors(poses, target) * np.repeat((1.0, LEVER), 3)
    return np.asarray(postures[np.argsort((errors**2).sum(axis=1), kind="stable")[:NEAREST]])


def _approach(chain: Chain, target: Array, starts: Array, tolerance: float) -> Array:
    """Search from many starts at once; returns the configurations with smaller errors."""
    configurations, damping = starts, np.full(len(starts), 1e-3)
    poses, jacobians = chain.jacobians(configurations)
    errors = _errors(poses, target)
    near: list[Array] = []
    for _ in range(MAX_ITERATIONS):
        is_near = np.abs(errors).max(axis=1) < tolerance
        near.extend(configurations[is_near])
        goes_on = ~is_near & (damping <= MAX_DAMPING)
        if not goes_on.any():
            break
        configurations, damping = configurations[goes_on], damping[goes_on]
        jacobians, errors = jacobians[goes_on], errors[goes_on]
        steps = _steps_within_limits(chain, configurations, jacobians, errors, damping)
        steps *= np.minimum(1.0, MAX_STEP / np.maximum(np.abs(steps).max(axis=1), 1e-12))[:, None]
        tried = np.clip(configurations + steps, chain.limits.lower, chain.limits.upper)
        poses, tried_jacobians = chain.jacobians(tried)
        tried_errors = _errors(poses, target)
        better = (tried_errors**2).sum(axis=1) < (errors**2).sum(axis=1)
        configurations = np.where(better[:, None], tried, configurations)
        jacobians = np.where(better[:, None, None], tried_jacobians, jacobians)
        errors = np.where(better[:, None], tried_errors, errors)
        damping = np.where(better, np.maximum(damping / 10.0, MIN_DAMPING), damping * 10.0)
    return np.array(near).reshape(-1, starts.shape[1])


def _steps_within_limits(
    chain: Chain, configurations: Array, jacobians: Array, errors: Array, damping: Array
) -> Array:
    """Return damped steps that hold joints at limits which they would pass, shape (m, n)."""
    at_lower, at_upper = configurations <= chain.limits.lower, configurations >= chain.limits.upper
    moves = np.ones(configurations.shape, dtype=np.bool_)
    for _ in range(HOLDS):
        free = jacobians * moves[:, None, :]
        turned = free.transpose(0, 2, 1)
        system = free @ turned + damping[:, None, None] * np.eye(6)
        steps: Array = (turned @ np.linalg.solve(system, errors[:, :, None]))[:, :, 0]
        passing = (at_lower & (steps < 0.0)) | (at_upper & (steps > 0.0))
        if not passing.any():
            break
        moves &= ~passing
    return steps


def _errors(poses: Array, target: Array) -> Array:
    """Return the errors of many poses as `_error` does, shape (m, 6)."""
    turns = target[:3, :3] @ poses[:, :3, :3].transpose(0, 2, 1)
    skew = np.stack(
        [turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(skew, axis=1) / 2.0
    angle = np.arctan2(sine, (turns.trace(axis1=1, axis2=2) - 1.0) / 2.0)
    vectors = skew * (angle / np.maximum(2.0 * sine, 1e-12))[:, None]
    for index in np.flatnonzero(sine <= HALF_TURN):  # ill-conditioned there
        vectors[index] = rotation_vector(turns[index])
    return np.concatenate([target[:3, 3] - poses[:, :3, 3], vectors], axis=1)


def nearest_turns(chain: Chain, configuration: Array, start: Array) -> Array:
    """Shift each joint that turns by whole turns within its limits to be nearest to a start."""
    turn = 2.0 * math.pi
    near = configuration + turn * np.round((start - configuration) / turn)
    is_possible = ~chain.limits.slides & (near >= chain.limits.lower) & (near <= chain.limits.upper)
    return np.where(is_possible, near, configuration)


def pose_error(pose: Array, target: Array) -> tuple[float, float]:
    """Return the distance [m] and angle [rad] between two poses."""
    error = _error(pose, target)
    return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))


def _is_small(error: Array) -> bool:
    return bool(np.linalg.norm(error[:3]) < POSITION_TOLERANCE and np.linalg.norm(error[3:]) < ANGLE_TOLERANCE)


def _error(pose: Array, target: Array) -> Array:
    """Return the motion from one pose to another: translation [m] and rotation vector [rad], shape (6,)."""
    return np.concatenate([target[:3, 3] - pose[:3, 3], rotation_vector(target[:3, :3] @ pose[:3, :3].T)])


def rotation_vector(rotation: Array) -> Array:
    """Return axis times angle [rad] of a (3, 3) rotation matrix, shape (3,)."""
    skew = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = float(np.linalg.norm(skew)) / 2.0, (float(np.trace(rotation)) - 1.0) / 2.0
    angle = math.atan2(sine, cosine)
    if sine > 1e-9:
        return skew * (angle / (2.0 * sine))
    if cosine > 0.0:
        return skew / 2.0
    # Half a turn: the axis is the longest column of (R + 1) / 2.
    columns = (rotation + np.eye(3)) / 2.0
    axis = columns[:, int(np.argmax(np.diag(columns)))]
    return angle * axis / np.linalg.norm(axis)
