from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.manipulation.chain import Chain
from sim_nodes.manipulation.inverse_kinematics import (
    _errors,
    _search,
    nearest_turns,
    out_of_reach,
    pose_error,
    rotation_vector,
    solutions,
    solve,
)
from sim_nodes.noise import Noise
from tests.sim_nodes.manipulation.bench import CHAIN, HOME, configurations, downward


def test_every_pose_above_the_table_is_found_from_home() -> None:
    draw = np.random.default_rng(0)
    for _ in range(50):
        x, y, yaw = draw.uniform((0.45, -0.35, -math.pi / 4), (0.85, 0.35, math.pi / 4))
        target = downward(x, y, 0.1, yaw)
        found = solve(CHAIN, target, HOME)
        assert found is not None
        distance, angle = pose_error(CHAIN.tool_pose(found), target)
        assert distance < 1e-6
        assert angle < 1e-6


def test_the_solution_nearest_to_the_start_is_found() -> None:
    target = CHAIN.tool_pose(HOME + 0.1)
    found = solve(CHAIN, target, HOME)
    assert found is not None
    np.testing.assert_allclose(found, HOME + 0.1, atol=1e-5)


def test_a_pose_out_of_reach_has_no_solution() -> None:
    assert solve(CHAIN, downward(2.0, 0.0, 0.1), HOME) is None
    assert list(solutions(CHAIN, downward(2.0, 0.0, 0.1), HOME, HOME, Noise(0, "test"))) == []


def test_all_solutions_of_a_pose_reach_it() -> None:
    target = downward(0.6, 0.2, 0.2)
    found = list(solutions(CHAIN, target, HOME, HOME, Noise(0, "test")))
    assert len(found) >= 4
    for configuration in found:
        assert pose_error(CHAIN.tool_pose(configuration), target)[0] < 1e-6
        assert np.all(configuration >= CHAIN.limits.lower)
        assert np.all(configuration <= CHAIN.limits.upper)
    ways = [float(np.abs(configuration - HOME).max()) for configuration in found[1:]]
    assert ways == sorted(ways)
    again = list(solutions(CHAIN, target, HOME, HOME, Noise(0, "test")))
    assert all(np.array_equal(one, other) for one, other in zip(found, again, strict=True))


def test_whole_turns_are_removed_within_limits() -> None:
    near = nearest_turns(
        CHAIN, np.array([6.0, 0.0, 3.0, -6.0, 0.0, 0.0]), np.array([0.0, 6.0, -3.0, 0.0, 0.0, 0.0])
    )
    turn = 2 * math.pi
    np.testing.assert_allclose(near, (6.0 - turn, turn, 3.0, turn - 6.0, 0.0, 0.0))


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.3, 3.0, math.pi - 1e-10, math.pi])
def test_rotation_vectors_equal_axis_times_angle(angle: float) -> None:
    for axis in configurations(5, seed=2)[:, :3]:
        unit = axis / np.linalg.norm(axis)
        cross = np.array([[0, -unit[2], unit[1]], [unit[2], 0, -unit[0]], [-unit[1], unit[0], 0]])
        rotation = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        vector = rotation_vector(rotation)
        either = min(np.linalg.norm(vector - angle * unit), np.linalg.norm(vector + angle * unit))
        assert either < 1e-7
        if angle < 3.1:
            np.testing.assert_allclose(vector, angle * unit, atol=1e-9)


SEVEN = (  # joints of an arm with an elbow: place, turn, limits
    ("0 0 0.333", "0 0 0", -2.9, 2.9),
    ("0 0 0", "-1.5708 0 0", -1.76, 1.76),
    ("0 -0.316 0", "1.5708 0 0", -2.9, 2.9),
    ("0.0825 0 0", "1.5708 0 0", -3.07, -0.07),
    ("-0.0825 0.384 0", "-1.5708 0 0", -2.9, 2.9),
    ("0 0 0", "1.5708 0 0", -0.02, 3.75),
    ("0.088 0 0", "1.5708 0 0", -2.9, 2.9),
)


@pytest.fixture(scope="module")
def seven() -> Chain:
    text = '<robot name="seven"><link name="l0"/>'
    for number, (place, turn, lower, upper) in enumerate(SEVEN, 1):
        text += (
            f'<link name="l{number}"/><joint name="j{number}" type="revolute"><origin xyz="{place}" rpy="{turn}"/>'
            f'<parent link="l{number - 1}"/><child link="l{number}"/><axis xyz="0 0 1"/>'
            f'<limit lower="{lower}" upper="{upper}" velocity="2" effort="80"/></joint>'
        )
    text += '<link name="tool"/><joint name="tip" type="fixed"><origin xyz="0 0 0.107"/><parent link="l7"/>'
    text += '<child link="tool"/></joint></robot>'
    return Chain(text, "l0", "tool", [f"j{number}" for number in range(1, 8)])


def test_a_seven_joint_arm_reaches_a_pose_with_any_seed(seven: Chain) -> None:
    target, start = downward(0.45, 0.0, 0.25), np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    for seed in range(4):
        found = _search(seven, target, start, Noise(seed, "test"))
        assert found
        for configuration in found:
            assert pose_error(seven.tool_pose(configuration), target)[0] < 1e-6


def test_searches_hold_joints_at_their_limits(seven: Chain) -> None:
    shares = np.array([0.2, 0.001, 0.999, 0.5, 0.3, 0.001, 0.9])  # three joints near limits
    target = seven.tool_pose(seven.limits.lower + shares * (seven.limits.upper - seven.limits.lower))
    found = _search(seven, target, np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]), Noise(0, "test"))
    assert len(found) > 15  # of 128 starts; 6 without
    assert max(max(pose_error(seven.tool_pose(each), target)) for each in found) < 1e-6


@pytest.mark.slow
def test_poses_of_seven_joint_arms_are_found(seven: Chain) -> None:
    draw, limits = np.random.default_rng(3), seven.limits
    start = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    for seed in range(20):
        target = seven.tool_pose(draw.uniform(limits.lower, limits.upper))
        assert next(solutions(seven, target, start, start, Noise(seed, "test")), None) is not None


def test_batch_kinematics_equal_single_kinematics(seven: Chain) -> None:
    drawn = np.random.default_rng(0).uniform(seven.limits.lower, seven.limits.upper, size=(20, 7))
    poses, jacobians = seven.jacobians(drawn)
    target = poses[0]
    for index, configuration in enumerate(drawn):
        pose, jacobian = seven.jacobian(configuration)
        np.testing.assert_allclose(poses[index], pose, atol=1e-12)
        np.testing.assert_allclose(jacobians[index], jacobian, atol=1e-12)
        expected = np.concatenate([target[:3, 3] - pose[:3, 3], rotation_vector(target[:3, :3] @ pose[:3, :3].T)])
        np.testing.assert_allclose(_errors(poses, target)[index], expected, atol=1e-8)


def test_a_pose_beyond_the_stretched_arm_is_out_of_reach(seven: Chain) -> None:
    assert seven.reach == pytest.approx(0.316 + math.hypot(0.0825, 0.384) + 0.0825 + 0.088 + 0.107)
    assert out_of_reach(seven, downward(2.0, 0.0, 0.333)) == pytest.approx(2.0 - seven.reach)
    assert out_of_reach(seven, downward(0.5, 0.0, 0.3)) == 0.0
