from __future__ import annotations

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import verbs
from tests.sim_nodes.client import ROBOT, TRUTH, Client


def test_every_verb_of_the_wire_is_served(maze: Client) -> None:
    assert set(verbs.HANDLERS) == {verb.name for verb in wire.VERBS}


def test_features_list_robots_and_verbs(maze: Client) -> None:
    features = maze.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert (features.engine, features.world, features.step) == ("mujoco", "maze", 0.004)
    [robot] = features.robots
    assert robot.name == ROBOT
    assert robot.kinds == ("differential_drive_robot", "robot", "osc_actor")
    assert {"map", "odom", "base_link", f"{ROBOT}/base_link", TRUTH} <= set(robot.frames)


def test_unknown_verbs_are_refused(maze: Client) -> None:
    with pytest.raises(RequestRefused, match="unknown verb 'dance'") as refused:
        verbs.handle(maze.simulator, "dance", b"")
    assert refused.value.code == Result.FEATURE_UNSUPPORTED


@pytest.mark.parametrize("payload", [b"", b"\xc1", b"\x01", wire.encode(wire.Empty())])
def test_invalid_payloads_are_refused(maze: Client, payload: bytes) -> None:
    with pytest.raises(RequestRefused, match="not a valid Advance") as refused:
        verbs.handle(maze.simulator, "advance", payload)
    assert refused.value.code == Result.OPERATION_FAILED


def test_a_frame_without_a_pose_is_distinguished_from_an_unknown_one(maze: Client) -> None:
    for frame, code in (("base_link", Result.INCORRECT_STATE), ("nose", Result.NOT_FOUND)):
        with pytest.raises(RequestRefused) as refused:
            maze.ask(wire.GET_RELATIVE_POSE, wire.RelativePose(frame=frame, parent_frame="map", distance=1.0))
        assert refused.value.code == code
