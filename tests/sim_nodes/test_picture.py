from __future__ import annotations

import io

import matplotlib.image
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from seoro.bridges import wire
from sim_nodes.picture import GOAL, ROBOTS, SPAWNED, WALL, WIDTH
from tests.sim_nodes.client import Client, pose

# Corners of the axes in parts of the picture, for a world that is as wide as it is high.
LEFT, RIGHT = 0.085, 0.965


def picture(client: Client) -> NDArray[np.float64]:
    artifacts = client.ask(wire.GET_ARTIFACTS, wire.Empty()).artifacts
    [artifact] = [each for each in artifacts if each.name == "top_down.png"]
    assert (artifact.name, artifact.media_type) == ("top_down.png", "image/png")
    assert "world" in artifact.description
    pixels: NDArray[np.float64] = np.asarray(matplotlib.image.imread(io.BytesIO(artifact.data), format="png"))
    return pixels[:, :, :3]


def shows(pixels: NDArray[np.float64], colour: str) -> NDArray[np.bool_]:
    close: NDArray[np.bool_] = np.abs(pixels - to_rgb(colour)).max(axis=2) < 0.02
    return close


def columns(x: float, extent: float) -> float:
    """The column of the picture that an x of the world is in."""
    return WIDTH * (LEFT + (RIGHT - LEFT) * (x + extent) / (2 * extent))


def test_the_picture_shows_walls_path_goal_and_what_was_spawned(maze: Client) -> None:
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


def test_worlds_without_walls_and_with_every_shape_are_drawn(empty: Client) -> None:
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
