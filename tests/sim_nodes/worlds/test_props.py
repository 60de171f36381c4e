from __future__ import annotations

import math
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Result, WorldResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.navigation.maps import build_map
from sim_nodes.physics import Box, Cylinder, Sphere
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.client import BOX, Client, pose

PROPS = """
name: w
extent: [-4, -4, 4, 4]
props:
  - {name: crate, box: [0.4, 0.6, 0.5], mass: 4.0, colour: [0.5, 0.4, 0.3], pose: {x: 1.0, y: 1.0, yaw: 0.3}}
  - {name: die, cube: 0.1, mass: 0.1, friction: 0.4, pose: {x: 1.0, y: 1.0, z: 0.6}}
  - {name: column, cylinder: {radius: 0.2, length: 1.0}, pose: {x: -1.0}}
  - {name: ball, sphere: 0.1, mass: 0.2, pose: {x: -1.0, y: 2.0}}
"""


def world_file(folder: Path, text: str = PROPS) -> str:
    path = folder / "w.yaml"
    path.write_text(text)
    return str(path)


def test_shapes_stand_on_the_floor_by_default() -> None:
    crate, die, column, ball = parse_world(PROPS, "w").props
    assert [prop.model.parts[0].shape for prop in (crate, die, column, ball)] == [
        Box((0.4, 0.6, 0.5)),
        Box((0.1, 0.1, 0.1)),
        Cylinder(0.2, 1.0),
        Sphere(0.1),
    ]
    assert [prop.state.position[2] for prop in (crate, die, column, ball)] == pytest.approx([0.25, 0.6, 0.5, 0.1])
    assert (crate.model.mass, crate.model.colour, die.model.friction) == (4.0, (0.5, 0.4, 0.3, 1.0), 0.4)


def test_props_without_mass_are_static_and_in_the_map() -> None:
    world = parse_world(PROPS, "w")
    assert [prop.name for prop in world.props if prop.model.static] == ["column"]
    known = build_map(world.extent, world.walls, world.outlines)
    assert known.distance[known.grid.cell(-1.0, 0.0)] == 0.0
    assert known.distance[known.grid.cell(-0.5, 0.0)] == pytest.approx(0.325, abs=2e-3)
    assert known.distance[known.grid.cell(1.0, 1.0)] > 1.0


def test_overhead_props_are_not_in_the_map() -> None:
    text = PROPS.replace("pose: {x: -1.0}}", "pose: {x: -1.0, z: 1.1}}")
    assert parse_world(text, "w").outlines == ()


@pytest.mark.parametrize("engine", ENGINES)
def test_props_are_entities_of_the_world(engine: str, tmp_path: Path) -> None:
    client = Client(world_file(tmp_path), engine=engine)
    names = ("ball", "column", "crate", "die")
    assert client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == names
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    states = {name: client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=name)).pose.position for name in names}
    assert (states["die"].z, states["crate"].z) == pytest.approx((0.55, 0.25), abs=2e-3)
    with pytest.raises(RequestRefused, match="belongs to the world"):
        client.ask(wire.DELETE_ENTITY, wire.EntityName(name="ball"))
    with pytest.raises(RequestRefused, match="would overlap crate"):
        client.spawn("box", pose(1.0, 1.0), BOX)
    with pytest.raises(RequestRefused, match="below the floor") as refused:
        client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="ball", pose=pose(2.0, 2.0)))
    assert refused.value.code != Result.OK
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="ball", pose=pose(2.0, 2.0, z=0.1)))
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    ball = client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="ball")).pose.position
    assert (ball.x, ball.y) == pytest.approx((-1.0, 2.0))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_movable_prop_inside_another_is_refused(engine: str, tmp_path: Path) -> None:
    client = Client("empty", engine=engine)
    client.advance(1.0)
    path = world_file(tmp_path, PROPS.replace("y: 1.0, z: 0.6", "y: 1.0, z: 0.4"))
    with pytest.raises(RequestRefused, match=r"prop 'crate' at \(1.00, 1.00\) overlaps die") as refused:
        client.ask(wire.LOAD_WORLD, wire.LoadWorld(world=path, seed=0))
    assert refused.value.code == WorldResult.RESOURCE_PARSE_ERROR
    features = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert (features.world, features.time) == ("empty", 0.0)
    assert client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == ("turtlebot4",)


@pytest.mark.parametrize(
    ("prop", "words"),
    [
        ("{name: a}", "props.0: .*expected one of box, cube, cylinder, sphere, model in a prop, found none"),
        ("{name: a, cube: 1, sphere: 1}", "found cube and sphere"),
        ("{name: a, cube: 0.001}", "props.0.cube"),
        ("{name: a, cube: 1, mass: 0}", "props.0.mass"),
        ("{name: a, cube: 1, static: true}", "unexpected `static`"),
        ("{name: a, model: a.sdf, mass: 1}", "unexpected `mass` or `friction`"),
        ("{name: a, cube: 1, colour: [2, 0, 0]}", "props.0.colour.0"),
        ("{name: a, cube: 1, pose: {z: 0.2}}", "props.0.pose.z: 'a' would be 0.300 m below the floor"),
        ("{name: a, cube: 1}, {name: a, cube: 1}", "duplicate name 'a' of a prop"),
        ("{name: walls, cube: 1}", "duplicate name 'walls' of a prop"),
        ("{name: a, model: none.sdf}", "props.0.model: cannot read .*none.sdf"),
    ],
)
def test_an_invalid_prop_is_refused_with_the_key(prop: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=words) as error:
        parse_world(f"name: w\nextent: [-4, -4, 4, 4]\nprops: [{prop}]\n", "w.yaml", tmp_path)
    assert str(error.value).startswith("w.yaml")


def test_models_are_found_beside_the_world(tmp_path: Path) -> None:
    (tmp_path / "box.sdf").write_text(BOX)
    text = "name: w\nextent: [-4, -4, 4, 4]\nprops: [{name: a, model: box.sdf, static: true, colour: [1, 0, 0]}]\n"
    [prop] = parse_world(text, "w", tmp_path).props
    assert (prop.model.static, prop.model.colour) == (True, (1.0, 0.0, 0.0, 1.0))
    (tmp_path / "box.sdf").write_text("<sdf/>")
    with pytest.raises(WorldError, match=r"props.0.model: box.sdf: found no shapes besides floors"):
        parse_world(text, "w", tmp_path)


def test_a_tilted_box_covers_its_outline_from_above() -> None:
    tilted = f"{{name: a, box: [1, 0.4, 0.2], pose: {{roll: 0.4, pitch: 0.3, yaw: {math.pi / 2}}}}}"
    world = parse_world(f"name: w\nextent: [-4, -4, 4, 4]\nprops: [{tilted}]\n", "w")
    known = build_map(world.extent, (), world.outlines)
    assert known.distance[known.grid.cell(0.0, 0.0)] == 0.0
    assert known.distance[known.grid.cell(0.0, 0.45)] == 0.0
    assert known.distance[known.grid.cell(0.45, 0.0)] > 0.1
