from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.arms import UR10E
from sim_nodes.geometry import Array
from sim_nodes.manipulation.chain import Chain, inverse, pose_matrix
from tests.sim_nodes.manipulation.bench import CHAIN, HOME, configurations

# The table that Universal Robots publishes for the UR10e: d [m], a [m], alpha [rad].
TABLE = (
    (0.1807, 0.0, math.pi / 2),
    (0.0, -0.6127, 0.0),
    (0.0, -0.57155, 0.0),
    (0.17415, 0.0, math.pi / 2),
    (0.11985, 0.0, -math.pi / 2),
    (0.11655, 0.0, 0.0),
)
HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])  # of the base of ROS against that of the table
FLANGE_TO_TOOL = 0.135  # [m]


def by_table(positions: Array) -> Array:
    """Return the pose of the tool by the Denavit-Hartenberg convention."""
    pose = HALF_TURN
    for angle, (d, a, alpha) in zip(positions.tolist(), TABLE, strict=True):
        cos, sin, tilt, rise = math.cos(angle), math.sin(angle), math.cos(alpha), math.sin(alpha)
        pose = pose @ np.array(
            [
                [cos, -sin * tilt, sin * rise, a * cos],
                [sin, cos * tilt, -cos * rise, a * sin],
                [0.0, rise, tilt, d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return pose @ pose_matrix((0.0, 0.0, FLANGE_TO_TOOL), np.eye(3))


def test_the_tool_pose_matches_the_published_table() -> None:
    for positions in configurations(200):
        np.testing.assert_allclose(CHAIN.tool_pose(positions), by_table(positions), atol=1e-6)


def test_the_tool_points_down_in_front_of_the_arm_at_home() -> None:
    tool = CHAIN.tool_pose(HOME)
    np.testing.assert_allclose(tool[:3, 2], (0.0, 0.0, -1.0), atol=1e-4)
    assert 0.6 < tool[0, 3] < 0.8


def test_the_jacobian_matches_finite_differences() -> None:
    step = 1e-6
    for positions in configurations(5, seed=1):
        pose, jacobian = CHAIN.jacobian(positions)
        for joint in range(len(HOME)):
            moved = CHAIN.tool_pose(positions + step * np.eye(len(HOME))[joint])
            np.testing.assert_allclose((moved - pose)[:3, 3] / step, jacobian[:3, joint], atol=1e-5)
            spin = (moved[:3, :3] @ pose[:3, :3].T - np.eye(3)) / step
            np.testing.assert_allclose((spin[2, 1], spin[0, 2], spin[1, 0]), jacobian[3:, joint], atol=1e-5)


def test_the_jacobian_of_a_joint_that_slides_matches_finite_differences() -> None:
    chain = Chain(UR10E.urdf, UR10E.base_link, "left_finger", (*CHAIN.joints, "left_finger_joint"))
    positions, step = np.array([*HOME, 0.02]), 1e-6
    pose, jacobian = chain.jacobian(positions)
    moved = chain.tool_pose(positions + step * np.eye(7)[6])
    np.testing.assert_allclose((moved - pose)[:3, 3] / step, jacobian[:3, 6], atol=1e-6)
    np.testing.assert_array_equal(jacobian[3:, 6], np.zeros(3))
    poses, jacobians = chain.jacobians(positions[None])
    np.testing.assert_allclose(poses[0], pose, atol=1e-12)
    np.testing.assert_allclose(jacobians[0], jacobian, atol=1e-12)
    velocity = chain.velocity_at(positions, np.array([0.0] * 6 + [0.1]), 7, pose[:3, 3])
    np.testing.assert_allclose(velocity, 0.1 * jacobian[:3, 6], atol=1e-12)


def test_limits_are_read_from_the_urdf() -> None:
    limits = CHAIN.limits
    np.testing.assert_allclose(limits.upper, np.radians([360, 360, 180, 360, 360, 360]))
    np.testing.assert_allclose(limits.lower, -limits.upper)
    np.testing.assert_allclose(limits.speed, np.radians([120, 120, 180, 180, 180, 180]))


def test_a_pose_and_its_inverse_cancel() -> None:
    pose = CHAIN.tool_pose(HOME)
    np.testing.assert_allclose(pose @ inverse(pose), np.eye(4), atol=1e-12)


@pytest.mark.parametrize(
    ("tool", "joints", "words"),
    [
        ("nowhere", CHAIN.joints, "nowhere has no parent joint"),
        ("tcp", CHAIN.joints[:5], r"from base_link to tcp; expected \["),
    ],
)
def test_chains_other_than_declared_are_refused(tool: str, joints: tuple[str, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Chain(UR10E.urdf, "base_link", tool, joints)
