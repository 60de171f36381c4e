from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from PIL import Image

from sim_nodes.__main__ import ENGINES
from sim_nodes.navigation.maps import build_map
from sim_nodes.physics import BodyModel, BodyState, Part, Sphere
from sim_nodes.worlds.floor_plan import merged
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.engines import make_engine

ROOM = np.full((40, 60), 254, dtype=np.uint8)  # of 3 by 2 metres
ROOM[[0, -1], :] = 0
ROOM[:, [0, -1]] = 0
ROOM[:20, 30] = 0  # a wall from the top to the middle
PLAN = "image: plan.png, resolution: 0.05, origin: [-1.0, -0.5, 0.0]"


def world_text(plan: str = f"{{{PLAN}}}") -> str:
    return f"name: w\nfloor_plan: {plan}\n"


def save(folder: Path, pixels: NDArray[np.uint8] = ROOM, name: str = "plan.png") -> Path:
    Image.fromarray(pixels).save(folder / name)
    return folder


@given(arrays.arrays(np.bool_, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_boxes_cover_each_dark_pixel_once_and_no_other(mask: NDArray[np.bool_]) -> None:
    covered = np.zeros(mask.shape, dtype=int)
    for left, top, right, bottom in merged(mask):
        covered[top:bottom, left:right] += 1
    assert np.array_equal(covered, mask.astype(int))


def test_straight_walls_are_one_box_each() -> None:
    assert len(merged(ROOM < 128)) == 5


def test_walls_match_the_dark_pixels(tmp_path: Path) -> None:
    world = parse_world(world_text(), "w", save(tmp_path))
    assert world.extent == (-1.0, -0.5, 2.0, 1.5)
    known = build_map(world.extent, world.walls)
    dark = known.distance.T[::-1] == 0.0  # rows from the top
    assert np.array_equal(dark, ROOM == 0)


def test_a_rotated_plan_rotates_about_its_lower_left_corner(tmp_path: Path) -> None:
    text = world_text(f"{{{PLAN.replace('0.0]', f'{math.pi / 2}]')}}}")
    world = parse_world(text, "w", save(tmp_path))
    assert world.extent == pytest.approx((-3.0, -0.5, -1.0, 2.5))
    straight = parse_world(world_text(), "w", tmp_path)
    for turned, wall in zip(world.walls, straight.walls, strict=True):
        assert (turned.x + 1.0, turned.y + 0.5) == pytest.approx((-(wall.y + 0.5), wall.x + 1.0))


def test_a_file_of_the_map_server_is_a_floor_plan(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    save(tmp_path / "maps", name="plan.pgm")
    described = PLAN.replace(".png", ".pgm").replace(", ", "\n", 2)
    (tmp_path / "maps" / "plan.yaml").write_text(described + "\nnegate: 0\nmode: trinary\n")
    world = parse_world(world_text("maps/plan.yaml") + "wall_height: 0.8\n", "w", tmp_path)
    assert {wall.height for wall in world.walls} == {0.8}
    assert len(world.walls) == 5


@pytest.mark.parametrize("kind", ["negated", "transparent", "grey", "16 bit"])
def test_dark_pixels_are_wall(kind: str, tmp_path: Path) -> None:
    pixels, more = ROOM, ""
    match kind:
        case "negated":
            pixels, more = 255 - ROOM, ", negate: true"
        case "transparent":
            pixels = np.dstack([np.zeros_like(ROOM)] * 3 + [np.where(ROOM == 0, 255, 0).astype(np.uint8)])
        case "grey":  # 205 is what map servers write for unknown
            pixels = np.where(ROOM == 0, 60, 205).astype(np.uint8)
        case _:
            Image.fromarray(ROOM.astype(np.uint16) * 257).save(tmp_path / "plan.png")
    if kind != "16 bit":
        save(tmp_path, pixels)
    assert len(parse_world(world_text(f"{{{PLAN}{more}}}"), "w", tmp_path).walls) == 5


@pytest.mark.parametrize("engine", ENGINES)
def test_walls_of_a_plan_are_solid(engine: str, tmp_path: Path) -> None:
    text = world_text() + "props: [{name: ball, sphere: 0.1, mass: 1.0, pose: {x: -0.5, y: 1.0}}]\n"
    world = parse_world(text, "w", save(tmp_path))
    made = make_engine(engine)
    made.build(world.scene)
    [ball] = world.props
    made.add_body("ball", ball.model, ball.state)
    made.set_body_state("ball", replace(ball.state, linear=(-1.0, 0.0, 0.0)))
    places = []
    for _ in range(made.steps_per_second):
        made.step()
        places.append(made.body_state("ball").position[0])
    assert min(places) == pytest.approx(-0.85, abs=0.02), "the wall's face is at x = -0.95"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_plan_with_many_walls_loads(engine: str, tmp_path: Path) -> None:
    dotted = ROOM.copy()
    dotted[5:-5:4, 5:-5:4] = 0
    world = parse_world(world_text(), "w", save(tmp_path, dotted))
    assert len(world.walls) > 100
    made = make_engine(engine)
    made.build(world.scene)
    ball = BodyModel((Part(Sphere(0.05)),))
    made.add_body("ball", ball, BodyState((-0.5, -0.15, 0.1)))
    assert made.overlaps("ball") == ("walls",)


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ("{image: plan.png}", "floor_plan"),
        (f"{{{PLAN}, mode: colour}}", "mode"),
        (f"{{{PLAN}, occupied_thresh: 0.2}}", "expected `free_thresh` below"),
        (f"{{{PLAN.replace('0.05', '0')}}}", "resolution"),
        (f"{{{PLAN.replace('plan.png', 'none.png')}}}", "floor_plan: cannot read the floor plan"),
        (f"{{{PLAN.replace('plan.png', 'text.png')}}}", "expected PNG, PGM or JPEG"),
        (f"{{{PLAN.replace('plan.png', 'cut.png')}}}", "cannot read the floor plan"),
        (f"{{{PLAN.replace('plan.png', 'noise.png')}}}", "boxes; expected at most 2000"),
        (f"{{{PLAN.replace('plan.png', 'large.png')}}}", "expected at most 4000000 altogether"),
        (f"{{{PLAN.replace('0.05', '0.01')}}}", "at least 1 m wide"),
        ("none.yaml", "floor_plan: cannot read"),
        ("wrong.yaml", "floor_plan: .*wrong.yaml:1: image: Field required"),
    ],
)
def test_an_invalid_plan_is_refused_with_the_key(plan: str, words: str, tmp_path: Path) -> None:
    save(tmp_path)
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "wrong.yaml").write_text("resolution: 0.05\norigin: [0, 0, 0]\n")
    (tmp_path / "cut.png").write_bytes((tmp_path / "plan.png").read_bytes()[:80])
    if "noise" in plan:
        save(tmp_path, np.random.default_rng(0).integers(0, 255, (120, 120), dtype=np.uint8), "noise.png")
    if "large" in plan:
        save(tmp_path, np.full((2001, 2001), 254, dtype=np.uint8), "large.png")
    with pytest.raises(WorldError, match=words) as error:
        parse_world(world_text(plan), "w.yaml", tmp_path)
    assert str(error.value).startswith("w.yaml")


def test_a_world_requires_an_extent() -> None:
    with pytest.raises(WorldError, match="expected `extent`, `floor_plan`, `generate` or `scene`"):
        parse_world("name: w\n", "w")
