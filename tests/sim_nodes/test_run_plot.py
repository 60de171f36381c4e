from __future__ import annotations

import io
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.run_plot import GOAL, ROBOTS, SPAWNED, SPAWNED_EDGE, WALL, WIDTH
from tests.sim_nodes.client import Client, pose

# Corners of the axes as shares of the image, for a square world.
LEFT, RIGHT = 0.085, 0.965


def picture(client: Client) -> NDArray[np.float64]:
    artifacts = client.ask(wire.GET_ARTIFACTS, wire.Empty()).artifacts
    [artifact] = [each for each in artifacts if each.name == "top_down.png"]
    assert (artifact.name, artifact.media_type) == ("top_down.png", "image/png")
    assert "from above" in artifact.description
    pixels: NDArray[np.float64] = np.asarray(matplotlib.image.imread(io.BytesIO(artifact.data), format="png"))
    return pixels[:, :, :3]


def shows(pixels: NDArray[np.float64], colour: str) -> NDArray[np.bool_]:
    close: NDArray[np.bool_] = np.abs(pixels - to_rgb(colour)).max(axis=2) < 0.02
    return close


def columns(x: float, extent: float) -> float:
    """Return the column of an x of the world in the image."""
    return WIDTH * (LEFT + (RIGHT - LEFT) * (x + extent) / (2 * extent))


def test_the_plot_shows_walls_path_goal_and_spawned_bodies(maze: Client) -> None:
    before = picture(maze)
    assert before.shape[1] == WIDTH
    assert shows(before, WALL).mean() > 0.02
    assert not shows(before, SPAWNED).any()
    maze.localise()
    maze.navigate(pose(0.0, 1.5))
    maze.advance(5.0)
    maze.spawn("box", pose(3.0, -3.0, 0.5))
    after = picture(maze)
    for colour, x in ((SPAWNED, 3.0), (GOAL, 0.1)):
        seen = np.nonzero(shows(after[: -WIDTH // 10], colour))[1]
        assert seen.mean() == pytest.approx(columns(x, 5.35), abs=15), colour
    assert shows(after, ROBOTS[0]).sum() > shows(before, ROBOTS[0]).sum() + 500, "the path is drawn"


def test_worlds_without_walls_and_all_shapes_are_plotted(empty: Client) -> None:
    link = '<link name="l"><collision name="c"><geometry>{}</geometry></collision></link>'
    shapes = (
        "<sphere><radius>0.5</radius></sphere>",
        "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
        "<box><size>1 1 1</size></box>",
    )
    for index, shape in enumerate(shapes):
        model = f'<sdf><model name="m">{link.format(shape)}</model></sdf>'
        empty.spawn(f"thing{index}", pose(3.0 * index - 3.0, 3.0, z=0.6), model)
    seen = np.nonzero(shows(picture(empty), SPAWNED).any(axis=0))[0]
    for index in range(3):
        assert np.abs(seen - columns(3.0 * index - 3.0, 10.0)).min() < 10


@pytest.mark.more
def test_the_path_of_a_moved_body_is_plotted(empty: Client) -> None:
    empty.spawn("box", pose(-3.0, 3.0))
    empty.advance(0.2)
    still = shows(picture(empty), SPAWNED_EDGE).sum()
    for step in range(1, 21):
        empty.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="box", pose=pose(-3.0 + 0.25 * step, 3.0)))
        empty.advance(0.2 + 0.1 * step)
    after = shows(picture(empty), SPAWNED_EDGE)
    assert after.sum() > still + 200
    along = np.nonzero(after.any(axis=0))[0]
    assert along.min() < columns(-2.8, 10.0) and along.max() > columns(1.8, 10.0)


@pytest.mark.more
def test_a_body_that_falls_has_no_path(empty: Client) -> None:
    empty.spawn("box", pose(-3.0, 3.0, z=0.5))
    before = shows(picture(empty), SPAWNED_EDGE).sum()
    for step in range(1, 11):
        empty.advance(0.1 * step)
    assert shows(picture(empty), SPAWNED_EDGE).sum() == pytest.approx(before, abs=20)


def test_a_body_spawned_again_has_a_new_path(empty: Client) -> None:
    def way() -> list[tuple[float, float]]:
        return [(round(x, 3), round(y, 3)) for x, y, _ in empty.simulator.simulation.run_data.trails["box"]]

    empty.spawn("box", pose(-3.0, 3.0))
    empty.advance(0.1)
    assert way() == [(-3.0, 3.0)]
    empty.ask(wire.DELETE_ENTITY, wire.EntityName(name="box"))
    empty.spawn("box", pose(4.0, 4.0))
    empty.advance(0.2)
    assert way() == [(4.0, 4.0)]
    empty.ask(wire.DELETE_ENTITY, wire.EntityName(name="box"))
    empty.advance(0.3)
    assert empty.simulator.simulation.run_data.trails == {}


def test_the_path_of_a_prop_is_plotted(tmp_path: Path) -> None:
    world = tmp_path / "props.yaml"
    crate = "{name: crate, cube: 0.5, mass: 1.0, pose: {x: -3.0}}"
    world.write_text(f"name: props\nextent: [-5, -5, 5, 5]\nprops: [{crate}]\n")
    client = Client(str(world))
    client.advance(0.1)
    still = shows(picture(client), WALL).sum()
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="crate", pose=pose(3.0, 1.0, z=0.25)))
    client.advance(1.0)  # the robot of the world is at rest
    assert shows(picture(client), WALL).sum() > still + 300


@pytest.mark.parametrize("engine", ENGINES)
def test_arms_and_paths_of_their_tools_are_plotted(engine: str, tmp_path: Path) -> None:
    world = tmp_path / "cell.yaml"
    world.write_text("name: cell\nextent: [-1.5, -1.5, 1.5, 1.5]\nrobots:\n  - {name: arm, robot: ur10e}\n")
    client = Client(str(world), engine=engine)
    before = picture(client)
    assert (np.abs(before - to_rgb(ROBOTS[0])).max(axis=2) < 0.3).sum() > 2000, "the arm is drawn, see-through"
    turned = np.array([1.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
    client.simulator.simulation.engine.command_joints("arm", turned, np.zeros(6))
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    tool = client.simulator.simulation.run_data.records["arm"].tool
    assert len(tool) > 5
    assert np.linalg.norm(np.subtract(tool[-1], tool[0])) > 0.3
    x, y, _ = tool[len(tool) // 2]
    row = before.shape[0] - 0.95 * 140 - (y + 1.5) / 3.0 * 0.88 * WIDTH
    seen = shows(picture(client), ROBOTS[0])[round(row) - 4 : round(row) + 4, :]
    assert seen[:, round(columns(x, 1.5)) - 4 : round(columns(x, 1.5)) + 4].any()


@pytest.mark.more
def test_a_plot_of_hundreds_of_bodies_labels_some(empty: Client) -> None:
    for index in range(60):
        empty.spawn(f"box{index}", pose(-8.0 + index % 20 * 0.8, 2.0 + index // 20 * 1.5))
    started = time.process_time()
    picture(empty)
    assert time.process_time() - started < 10.0
