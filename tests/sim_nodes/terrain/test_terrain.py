"""Terrain of world files, and what stands and drives on it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.check import Rule, terrain
from sim_nodes.check.bench import ROBOT as CHECKED
from sim_nodes.check.bench import drive, run
from sim_nodes.check.saving import checkpoint_of, restore, saved
from sim_nodes.geometry import roll_pitch_yaw
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.physics import BodyState, Engine, Rewinds, Scene
from sim_nodes.terrain.ground import Ground
from sim_nodes.worlds.files import files_of_world
from sim_nodes.worlds.loader import World, WorldError, parse_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import expect_broken, make_engine

HEAD = "name: w\nextent: [-5, -5, 5, 5]\nterrain:\n"
RAMP = f"{HEAD}  - {{ramp: {{size: [2, 1], heights: [0.0, 0.2]}}, center: [1, 0]}}\n"
ROBOTS = "robots:\n  - {name: turtlebot4, robot: turtlebot4, pose: {x: X}}\n"


def world(piece: str, more: str = "", seed: int = 0, folder: Path = Path()) -> World:
    return parse_world(f"{HEAD}  - {piece}\n{more}", "w.yaml", folder, seed=seed)


def written(folder: Path, text: str) -> str:
    path = folder / "w.yaml"
    path.write_text(text)
    return str(path)


def test_ramps_platforms_and_steps_have_heights() -> None:
    ground = parse_world(RAMP, "w").ground
    assert [round(ground.height(x, 0.4), 6) for x in (-0.1, 0.0, 0.5, 1.0, 2.0, 2.1)] == [0, 0, 0.05, 0.1, 0.2, 0]
    assert ground.height(1.0, 0.6) == 0.0
    turned = world("{ramp: {size: [2, 1], angle: 0.1}, center: [1, 0], yaw: 3.14159265}").ground
    assert turned.height(0.001, 0.0) == pytest.approx(2 * math.tan(0.1), abs=1e-3)
    steps = world("{steps: {count: 3, rise: 0.1, run: 0.5, width: 1}, yaw: 1.5707963267948966}").ground
    assert [round(steps.height(0.0, y), 6) for y in (-0.8, -0.7, -0.1, 0.1, 0.4, 0.8)] == [
        0,
        0.1,
        0.2,
        0.2,
        0.3,
        0,
    ]
    assert world("{platform: {size: [1, 1], height: 0.3}}").ground.height(0.4, 0.4) == 0.3


def test_a_picture_gives_heights(tmp_path: Path) -> None:
    pixels = np.zeros((5, 9), dtype=np.uint8)
    pixels[1, 2], pixels[:, 0] = 255, 255  # the edge is on the floor anyway
    Image.fromarray(pixels).save(tmp_path / "hills.png")
    text = "{heightfield: {image: hills.png, size: [4, 2], height: 0.5}}"
    ground = world(text, folder=tmp_path).ground
    assert [ground.height(*at) for at in ((-1.0, 0.5), (-0.75, 0.5), (-1.0, 0.25), (-2.0, 0.0))] == [
        0.5,
        0.25,
        0.25,
        0,
    ]
    path = written(tmp_path, f"{HEAD}  - {text}\n")
    assert [file.name for file in files_of_world(path)] == ["w.yaml", "hills.png"]


def test_rough_terrain_depends_on_the_seed_alone() -> None:
    rough = "{rough: {size: [4, 3], height: 0.1, spacing: 0.25SEED}}"
    own, first, again, other = (
        world(rough.replace("SEED", of), seed=seed).ground.fields[0]
        for of, seed in ((", seed: 7", 1), ("", 7), ("", 7), ("", 8))
    )
    assert own.data == first.data == again.data != other.data
    assert (own.rows, own.columns) == (13, 17)
    assert 0.08 < own.top <= 0.1
    assert not own.grid[0].any() and not own.grid[:, -1].any()


@pytest.mark.parametrize(
    ("piece", "words"),
    [
        ("{ramp: {size: [1, 1]}}", "expected either `heights` or `angle` of a ramp"),
        ("{ramp: {size: [1, 1], heights: [0, 0]}}", "invalid heights 0 and 0 of a ramp; expected 0 to 10 m"),
        ("{ramp: {size: [1, 1], heights: [0, 11]}}", "invalid heights 0 and 11"),
        ("{ramp: {size: [1, 1], heights: [0, -0.2]}}", r"terrain below the floor \(-0.2\): the floor"),
        ("{ramp: {size: [1, 1], angle: -0.1}}", "unsupported terrain below the floor"),
        ("{platform: {size: [1, 1], height: -0.3}}", "unsupported terrain below the floor"),
        ("{steps: {count: 2, rise: -0.1, run: 0.3, width: 1}}", "unsupported terrain below the floor"),
        ("{yaw: 1.0}", "expected one of ramp, platform, .* in a piece of terrain, found none"),
        ("{steps: {count: 50, rise: 1, run: 1, width: 1}}", "the steps are 50 m high; expected at most 10 m"),
        ("{rough: {size: [100, 100], height: 1, spacing: 0.05}}", "2001 by 2001 bumps; expected at most 40000"),
        ("{platform: {size: [1, 1], height: 1}, center: [6, 0]}", r"terrain.0.center: \(6, 0\) is outside"),
        ("{heightfield: {image: no.png, size: [1, 1], height: 1}}", "terrain.0: cannot read the heights .*no.png"),
        ("{heightfield: {image: black.png, size: [1, 1], height: 1}}", "terrain.0: the picture is black"),
        ("{heightfield: {image: tiny.png, size: [1, 1], height: 1}}", "tiny.png has 2 by 9 pixels; expected 3"),
        ("{heightfield: {image: huge.png, size: [1, 1], height: 1}}", "expected at most 40000 altogether"),
    ],
)
def test_invalid_terrain_is_refused(piece: str, words: str, tmp_path: Path) -> None:
    for name, shape in (("black", (5, 5)), ("tiny", (9, 2)), ("huge", (300, 300))):
        Image.fromarray(np.zeros(shape, dtype=np.uint8)).save(tmp_path / f"{name}.png")
    with pytest.raises(WorldError, match=words):
        world(piece, folder=tmp_path)


def test_robots_and_props_start_on_the_ground() -> None:
    more = ROBOTS.replace("X", "1.0") + (
        "  - {name: arm, robot: ur10e, pose: {x: 2.0, y: 0.3}}\nprops:\n"
        "  - {name: box, cube: 0.2, mass: 1, pose: {x: 0.5}}\n"
        "  - {name: high, cube: 0.2, mass: 1, pose: {x: 0.5, y: 0.3, z: 2}}\n"
    )
    loaded = parse_world(RAMP + more + "poses: [{name: top, pose: {x: 1.8}}]", "w")
    assert loaded.poses[0].place.position[2] == pytest.approx(0.18)
    robot, arm = (placed.state for placed in loaded.robots)
    assert robot.position == pytest.approx((1.0, 0.0, 0.101), abs=1e-3)
    assert roll_pitch_yaw(robot.orientation) == pytest.approx((0.0, -math.atan(0.1), 0.0), abs=1e-6)
    assert arm.position[2] == pytest.approx(0.2)
    assert arm.orientation == (1.0, 0.0, 0.0, 0.0)
    assert [prop.state.position[2] for prop in loaded.props] == pytest.approx([0.06 + 0.1, 2.0])


def test_a_robot_on_a_steep_slope_is_refused() -> None:
    steep = "{ramp: {size: [1, 2], angle: 0.8}}"
    with pytest.raises(WorldError, match=r"w.yaml:6: robots.0.pose: .* slope of 0.80 rad; expected at most"):
        world(steep, ROBOTS.replace("X", "0.0"))


@pytest.mark.parametrize("engine", ENGINES)
def test_states_in_terrain_are_raised_onto_it(engine: str, tmp_path: Path) -> None:
    make_engine(engine)
    client = Client(written(tmp_path, RAMP + ROBOTS.replace("X", "-1.0")), engine=engine)
    entities = client.simulator.simulation.entities
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(1.5, 0.0, math.pi / 2)))
    state = entities.state(ROBOT)
    assert state.position == pytest.approx((1.5, 0.0, 0.151), abs=1e-3)
    assert roll_pitch_yaw(state.orientation) == pytest.approx((-math.atan(0.1), 0.0, math.pi / 2), abs=1e-2)
    client.spawn("box", pose(0.5, 0.0))
    assert 0.05 < entities.state("box").position[2] < 0.08
    client.advance(1.0)
    assert entities.state(ROBOT).position == pytest.approx((1.5, 0.0, 0.15), abs=0.01)
    assert client.simulator.simulation.engine.touching() == frozenset()


def along(engine: Engine) -> list[BodyState]:
    """Return the states of a robot that drives up a ramp."""
    drive(engine, 0.3, 0.05)
    states = []
    for _ in range(5):
        run(engine, 0.2)
        states.append(engine.body_state(CHECKED))
    return states


@pytest.mark.parametrize("engine", ENGINES)
def test_saved_and_rewound_states_on_terrain_continue_identically(engine: str) -> None:
    first = terrain.built_terrain(lambda: make_engine(engine))
    drive(first, 0.3, 0.0, seconds=3.0)
    state, checkpoint = saved(first), checkpoint_of(first)
    expected = along(first)
    assert expected[0].position[2] > 0.03
    other = terrain.built_terrain(lambda: make_engine(engine))
    restore(other, state)
    assert along(other) == expected
    assert isinstance(first, Rewinds)
    first.rewind(checkpoint)
    assert along(first) == expected


@pytest.mark.parametrize("engine", ENGINES)
def test_people_walk_over_terrain(engine: str, tmp_path: Path) -> None:
    make_engine(engine)
    people = "people: [{name: ann, pose: {x: -1}, speed: 1.0, walk: {points: [[2.5, 0]]}}]\n"
    simulation = Client(written(tmp_path, RAMP + people), engine=engine).simulator.simulation
    heights = []
    for until in (1.0, 2.5, 3.5, 4.5):
        simulation.run(until)
        heights.append(simulation.engine.body_state("ann").position[2])
    assert heights[0] == pytest.approx(0.01, abs=0.01), "before the ramp"
    assert heights[1] == pytest.approx(0.145, abs=0.03), "in its middle"
    assert heights[2] == pytest.approx(0.21, abs=0.01), "at its end"
    assert heights[3] == pytest.approx(0.01, abs=0.01), "behind it"


class Flat(MujocoEngine):
    """It ignores terrain."""

    def build(self, scene: Scene) -> None:
        super().build(replace(scene, ground=Ground()))


@pytest.mark.parametrize("rule", [terrain.rays_hit_terrain_at_its_height, terrain.robots_drive_over_terrain])
def test_the_rules_find_engines_without_terrain(rule: Rule) -> None:
    expect_broken(rule, Flat, "instead of")
