"""The rules for arms find engines that break them: each engine here has one defect."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from sim_nodes.check import arms
from sim_nodes.geometry import Array
from sim_nodes.physics import BodyModel, BodyState, CarriedBody, JointStates, Overlap, Scene
from tests.sim_nodes.engines import expect_broken

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

from sim_nodes.mujoco.engine import MujocoEngine


class Sagging(MujocoEngine):
    """Its motors do not bear the weight."""

    def build(self, scene: Scene) -> None:
        super().build(scene)
        self._model.body_gravcomp[:] = 0.0


class Weightless(MujocoEngine):
    def build(self, scene: Scene) -> None:
        super().build(scene)
        self._model.opt.gravity[2] = 0.0


class Mirrored(MujocoEngine):
    """Its second joint turns the wrong way."""

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        home = arms.HOME
        sign = np.array([1, -1, 1, 1, 1, 1])
        super().command_joints(robot, home + sign * (positions - home), sign * velocities)


class Stuttering(MujocoEngine):
    """It does not advance joint targets between commands."""

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        super().command_joints(robot, positions, np.zeros_like(velocities))


class Strong(MujocoEngine):
    """It does not limit the force of the fingers."""

    def command_fingers(self, robot: str, position: float, force: float) -> None:
        super().command_fingers(robot, position, 200.0)


class Slippery(MujocoEngine):
    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        super().add_body(name, model, state)
        self._model.geom_friction[:] = 1e-3


class Numb(MujocoEngine):
    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        return frozenset()


class Thoughtless(MujocoEngine):
    """It predicts for the present posture, not for the given one."""

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        present = self.joint_states(robot).positions[: len(positions)]
        return super().arm_overlaps(robot, present, own, carried)


class Selfless(MujocoEngine):
    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        return super().arm_overlaps(robot, positions, (), None)


class Restless(MujocoEngine):
    """Predicting overlaps moves the arm."""

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        self._data.qpos[0] += 1e-12
        return super().arm_overlaps(robot, positions, own, carried)


class Retentive(MujocoEngine):
    """A reset keeps commands."""

    def reset(self) -> None:
        kept = self._data.ctrl.copy()
        super().reset()
        self._data.ctrl[:] = kept


class Rounding(MujocoEngine):
    def joint_states(self, robot: str) -> JointStates:
        states = super().joint_states(robot)
        return JointStates(states.positions.round(2), states.velocities, states.efforts)


@pytest.mark.parametrize(
    ("make", "rule", "words"),
    [
        (Rounding, arms.arms_keep_their_posture, "joints and fingers after 0.0 s"),
        (Sagging, arms.joints_reach_their_targets, "the positions of the joints"),
        (Mirrored, arms.joints_reach_their_targets, "the positions of the joints"),
        (Stuttering, arms.joints_follow_moving_targets, "joints that move"),
        (Weightless, arms.motors_support_the_weight, "effort of the second joint"),
        (Strong, arms.fingers_press_with_the_commanded_force, "the efforts of the fingers"),
        (Numb, arms.fingers_press_with_the_commanded_force, "touch [] instead of"),
        (Slippery, arms.gripped_bodies_are_carried, "how far the cube was lifted"),
        (Thoughtless, arms.predicted_overlaps_match_kinematics, "ahead of the tool overlaps []"),
        (Selfless, arms.predicted_overlaps_include_floor_and_links, "overlaps itself in []"),
        (Restless, arms.predicting_overlaps_changes_nothing, "differs from one without"),
        (Retentive, arms.a_reset_returns_arms_home, "a run after a reset"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_faulty_engine_breaks_a_rule(
    make: Callable[[], MujocoEngine], rule: Callable[[object], None], words: str
) -> None:
    expect_broken(rule, make, words)
