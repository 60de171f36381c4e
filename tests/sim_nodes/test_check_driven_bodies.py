"""Engines that drive bodies keep the rules for that, and defects break them."""

from __future__ import annotations

import numpy as np
import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check import OPTIONAL, Rule, check_rule, driven_bodies
from sim_nodes.geometry import Array
from sim_nodes.physics import DrivesBodies
from tests.sim_nodes.engines import expect_broken, make_engine

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

from sim_nodes.mujoco.engine import MujocoEngine

RULES = dict(OPTIONAL)[DrivesBodies]


class Level(MujocoEngine):
    """It ignores the heights of driven bodies."""

    def drive_bodies(self, velocities: Array, heights: Array) -> None:
        super().drive_bodies(velocities, np.full(len(heights), driven_bodies.LOW))


class Drifting(MujocoEngine):
    """Driven bodies move a little faster to x."""

    def drive_bodies(self, velocities: Array, heights: Array) -> None:
        super().drive_bodies(velocities + [[0.1, 0.0, 0.0]] * len(velocities), heights)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("engine", ENGINES)
def test_engines_drive_bodies(engine: str, rule: Rule) -> None:
    check_rule(rule, lambda: make_engine(engine))


@pytest.mark.parametrize(
    ("engine", "rule", "words"),
    [
        (Level, driven_bodies.driven_bodies_reach_heights, "the height of a driven body [m] is 0.11"),
        (Level, driven_bodies.built_in_bodies_carry_loads, "the height of a lifted cube"),
        (Drifting, driven_bodies.driven_bodies_follow_their_velocities, "the poses of driven bodies"),
        (Drifting, driven_bodies.driven_bodies_stop_robots, "the position of a driven body"),
        (Drifting, driven_bodies.built_in_bodies_pass_through_walls_and_the_floor, "the position of a built-in"),
    ],
)
def test_defects_break_a_rule(engine: type[MujocoEngine], rule: Rule, words: str) -> None:
    expect_broken(rule, engine, words)
