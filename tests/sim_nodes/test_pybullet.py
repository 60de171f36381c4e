from __future__ import annotations

import gc
import logging
import os
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from sim_nodes.check.arms import HOME, OUTSTRETCHED, PLACED, UR10E
from sim_nodes.check.bench import BASE, CUBE, EXTENT, ORIGIN, ROBOT, SHAPES, TURTLEBOT, at, body, built, drive, run
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.journal import Journal, calls_of
from sim_nodes.physics import BodyModel, BodyState, Box, Part, PlacedRobot, SavesState, Scene, UnsavableState, Wall
from sim_nodes.robots.reading import load_robot
from tests.sim_nodes.engines import make_engine

pytest.importorskip("pybullet", reason="the engine pybullet is not installed")

from sim_nodes.pybullet import captured_output, stepping
from sim_nodes.pybullet.rays import GROUPS

make = partial(make_engine, "pybullet")
LINKS = ("upper_arm_link", "forearm_link")


def test_output_of_c_code_is_logged_at_debug_level(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG, "sim_nodes")
    sys.stdout.write("before\n")
    with captured_output():
        os.write(1, b"from C\n")
        os.write(2, b"complaint from C\n")
    sys.stdout.write("after\n")
    assert capfd.readouterr() == ("before\nafter\n", "")
    assert [record.message for record in caplog.records] == ["from C", "complaint from C"]


def test_engines_print_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    engine = built(make, ORIGIN)
    engine.add_body("box", body(CUBE), at(0.0, 2.0, 1.0))
    run(engine, 0.1)
    engine.reset()
    del engine
    gc.collect()
    assert capfd.readouterr() == ("", "")


def test_engines_do_not_disturb_each_other() -> None:
    first, second = built(make, ORIGIN), built(make, ORIGIN)
    drive(first, 0.3, 0.0)
    run(first, 1.0)
    run(second, 1.0)
    assert first.body_state(ROBOT).position[0] > 0.25
    assert abs(second.body_state(ROBOT).position[0]) < 1e-3


@pytest.mark.parametrize(("thrown", "seed"), [(0, 1), (0, 2), (8, 3), (8, 4)])
def test_steps_without_contact_checks_miss_no_contact(
    thrown: int, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def course() -> tuple[list[tuple[int, list[tuple[str, str]]]], int]:
        """Return the steps in which contacts have changed, and the number of contact checks."""
        random, asked = Random(seed), 0
        engine: Any = built(make, ORIGIN, walls=(Wall("barrier", 1.5, 0.0, 0.0, 0.2, 2.0, 0.5),))
        look = engine._stepper._pairs

        def counted() -> frozenset[tuple[str, str]]:
            nonlocal asked
            asked += 1
            found: frozenset[tuple[str, str]] = look()
            return found

        monkeypatch.setattr(engine._stepper, "_pairs", counted)
        for index in range(thrown):
            shape = random.choice(list(SHAPES.values()))
            away = BodyState(
                (random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1.0 + index),
                linear=(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)),
                angular=(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), 0.0),
            )
            engine.add_body(f"body{index}", body(shape), away)
        engine.add_body("table", body(CUBE, static=True), at(-3.0, 0.0, 0.5))
        engine.add_body("dropped", body(CUBE), at(-3.0, 0.0, 1.0 + random.random()))
        drive(engine, 0.4, 0.0)
        changes: list[tuple[int, list[tuple[str, str]]]] = [(0, [])]
        made = 0
        while made < 4 * engine.steps_per_second:
            made += engine.step(100)
            changes.append((made, sorted(engine.touching())))
        return [each for each, last in zip(changes[1:], changes, strict=False) if each[1] != last[1]], asked

    found, asked = course()
    monkeypatch.setattr(stepping, "MANY", -1)
    wanted, always = course()
    assert found == wanted
    assert wanted
    assert asked < always


def test_deleted_engines_free_their_worlds() -> None:
    """Bullet has room for 1024 worlds in a process."""

    def place() -> object:
        engine: Any = make()
        engine.build(Scene((), (), (-1.0, -1.0, 1.0, 1.0)))
        return engine._client

    assert len({place() for _ in range(20)}) == 1


def test_parts_at_gimbal_lock_have_the_right_orientation() -> None:
    """URDF has roll, pitch and yaw, which are ambiguous at a pitch of 90 degrees."""
    engine = built(make)
    upright = quaternion(0.7, 1.5707963267948966, 0.2)
    plank = BodyModel((Part(Box((0.1, 0.2, 1.0)), orientation=upright),))
    engine.add_body("by part", plank, at(0.0, 0.0, 1.0))
    engine.add_body("by pose", BodyModel((Part(Box((0.1, 0.2, 1.0))),)), BodyState((0.0, 0.0, 1.0), upright))
    for probe in ((0.3, 0.2), (-0.3, -0.2), (0.2, -0.3), (-0.2, 0.3), (0.4, 0.0), (0.0, 0.4)):
        engine.add_body("probe", body(Box((0.05, 0.05, 0.05))), at(*probe, 1.0))
        assert len(engine.overlaps("probe")) in (0, 2), probe
        engine.remove_body("probe")


def test_saving_a_full_journal_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from sim_nodes import journal
    from sim_nodes.pybullet.engine import PybulletEngine

    monkeypatch.setattr(journal, "MAX_CALLS", 3)
    engine = PybulletEngine()
    engine.build(Scene((), (), (-1.0, -1.0, 1.0, 1.0)))
    engine.add_body("box", body(CUBE), at(0.0, 0.0, 1.0))
    for _ in range(3):
        engine.set_body_state("box", at(0.0, 0.0, 1.0))
    with pytest.raises(UnsavableState, match=r"than the limit \(3 calls"):
        engine.save()
    engine.reset()
    assert list(calls_of(engine.save())) == []


def test_a_journal_with_unknown_calls_is_refused() -> None:
    engine = built(make, ORIGIN)
    assert isinstance(engine, SavesState)
    for name in ("build", "step", "__init__", "nothing"):
        with pytest.raises(UnsavableState, match="unknown call"):
            reported = Journal()
            reported.record(name, ())
            engine.restore({"added": {}, **reported.save()})


def test_repeated_motor_commands_are_not_journaled() -> None:
    from sim_nodes.pybullet.engine import PybulletEngine

    engine = built(make, ORIGIN)
    assert isinstance(engine, PybulletEngine)
    for speed in (0.0, 1.0, 1.0, 2.0, 2.0):
        engine.command_wheels(ROBOT, speed, speed)
        engine.step(3)
    engine.power_wheels(ROBOT, False)
    engine.command_wheels(ROBOT, 2.0, 2.0)
    assert list(calls_of(engine.save())) == [
        (3, "set_motor_targets", (ROBOT, 1.0, 1.0)),
        (9, "set_motor_targets", (ROBOT, 2.0, 2.0)),
        (15, "power_wheels", (ROBOT, False)),
    ]


def frictions(engine: Any, name: str) -> dict[str, float]:
    """Return the sliding friction of all links of a robot or a body, by their names in Bullet."""
    bullet, number = engine._bullet, engine._bodies[name].number
    names = {-1: bullet.getBodyInfo(number)[0].decode()}
    names |= {
        index: bullet.getJointInfo(number, index)[12].decode() for index in range(bullet.getNumJoints(number))
    }
    return {link: bullet.getDynamicsInfo(number, index)[1] for index, link in names.items()}


def test_every_shape_has_the_friction_of_its_link() -> None:
    engine = built(make, ORIGIN)
    engine.add_body("pair", BodyModel((Part(CUBE), Part(CUBE, (0.5, 0.0, 0.0))), friction=0.7), at(2.0, 0.0, 0.1))
    slippery = dict.fromkeys(TURTLEBOT.low_friction_links, 0.0)
    assert frictions(engine, ROBOT) == {
        **dict.fromkeys(("base_link", "base_link#1", "rplidar_link"), TURTLEBOT.body_friction),
        **dict.fromkeys(("left_wheel", "right_wheel"), BASE.drive.wheel_friction),
        **slippery,
    }
    assert set(frictions(engine, "pair").values()) == {0.7}


def test_a_link_of_several_shapes_is_one_link() -> None:
    engine = make()
    engine.build(Scene((), (PLACED,), EXTENT))
    down = OUTSTRETCHED.copy()
    down[1] = 0.5  # [rad] below the horizontal
    found = {overlap.link for overlap in engine.arm_overlaps(ROBOT, down, (), None)}
    assert "forearm_link" in found
    assert not any("#" in name for name in found)
    folded = HOME.copy()
    folded[2] = 2.9
    [pair] = {(each.link, each.other) for each in engine.arm_overlaps(ROBOT, folded, (LINKS,), None)}
    assert pair == LINKS


def test_a_base_of_several_shapes_rests_without_contacts() -> None:
    from sim_nodes.pybullet.engine import PybulletEngine

    second = '<collision><origin xyz="0.1 0 0.04"/><geometry><box size="0.1 0.1 0.08"/></geometry></collision>'
    urdf = UR10E.urdf.replace("</collision>", f"</collision>{second}", 1)
    assert urdf != UR10E.urdf
    arm = replace(PLACED, declaration=UR10E.model_copy(update={"urdf": urdf}))
    engine = PybulletEngine()
    pedestal = Wall("pedestal", arm.pose.x, arm.pose.y, 0.0, 0.5, 0.5, arm.height)
    engine.build(Scene((pedestal,), (arm,), EXTENT))
    run(engine, 0.1)
    assert engine.touching() == frozenset()
    assert engine.link_contacts(ROBOT) == frozenset()
    assert engine.checkpoint() is not None


def test_building_scenes_again_takes_no_more_memory() -> None:
    engine = make()
    wide = Scene((), (), (-20.0, -20.0, 20.0, 20.0))
    for _ in range(5):
        engine.build(wide)
    before = resident()
    for _ in range(30):
        engine.build(wide)
    assert resident() - before < 4_000  # [KiB]; a floor has 500


def resident() -> int:
    return int(Path("/proc/self/status").read_text().partition("VmRSS:")[2].split()[0])


def test_robots_that_share_a_collision_group_see_each_other_but_not_themselves() -> None:
    declared, count = load_robot("turtlebot4"), GROUPS + 1
    places = [Pose2(0.5 * index, 0.0, 0.3 * index) for index in range(count)]
    directions = np.random.default_rng(0).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    found = []
    for first, last in ((0, 1), (10, 20)):  # these share a group
        order = [first, *(index for index in range(count) if index not in (first, last)), last]
        robots = tuple(PlacedRobot(f"robot{index}", declared, places[index]) for index in order)
        engine = make()
        engine.build(Scene((), robots, (-1.0, -1.0, 13.0, 1.0)))
        found.append([engine.cast_rays(f"robot{index}", "rplidar_link", directions, 5.0) for index in (0, 1, 10)])
    assert np.isfinite(found[0][0]).sum() > 50
    np.testing.assert_array_equal(found[0], found[1])
