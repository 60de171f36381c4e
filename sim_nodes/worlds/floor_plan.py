"""Walls from an image: a floor plan in the format of the ROS map server.

Each pixel is a square of floor; dark pixels are wall. They are merged into boxes: physics and the robots' maps
have the same walls.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seoro.files.yaml_lines import FileError, Lines, read_text, read_yaml, validate
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Wall
from sim_nodes.worlds.pictures import read_darkness
from sim_nodes.worlds.schema import FloorPlanFile, check_extent

MAX_PIXELS = 4_000_000
MAX_BOXES = 2000
OCCUPIED = 100  # value of an occupied cell in messages and raw maps

Mask = NDArray[np.bool_]
Box = tuple[int, int, int, int]  # first column, first row, and those after the last
Extent = tuple[float, float, float, float]


def load_floor_plan(
    plan: FloorPlanFile | str, folder: Path, height: float
) -> tuple[tuple[Wall, ...], Extent, tuple[str, ...]]:
    """Return the walls of a floor plan, its extent, and warnings.

    Args:
        plan: The floor plan, or the name of a map file (.yaml) that describes it.
        folder: Folder that relative file names start from.
        height: Height of the walls [m].

    Returns:
        The walls; lower x, lower y, upper x, upper y of the image [m]; and warnings.

    Raises:
        FileError: The file is missing or invalid, or gives too many walls.
    """
    ignored: tuple[str, ...] = ()
    try:
        if isinstance(plan, str):
            path = folder / plan
            (plan, ignored), folder = _described(path), path.parent
        return *_walls(plan, folder, height), ignored
    except FileError as error:
        raise FileError(f"floor_plan: {error}") from error


def _described(path: Path) -> tuple[FloorPlanFile, tuple[str, ...]]:
    """Read a map file; unknown keys are ignored with a warning, as by the map server."""
    text = read_text(path)
    content, lines = read_yaml(text, str(path)), Lines(text, str(path))
    ignored: tuple[str, ...] = ()
    if isinstance(content, dict):
        unknown = [key for key in content if key not in FloorPlanFile.model_fields]
        ignored = tuple(f"{lines.at([key])}: ignored unknown key `{key}` of a map" for key in unknown)
        content = {key: value for key, value in content.items() if key not in unknown}
    return validate(FloorPlanFile, content, lines), ignored


def _walls(plan: FloorPlanFile, folder: Path, height: float) -> tuple[tuple[Wall, ...], Extent]:
    mask = _occupied(read_darkness(folder / plan.image, "floor plan", MAX_PIXELS), plan)
    boxes = merged(mask)
    if len(boxes) > MAX_BOXES:
        raise FileError(
            f"{plan.image}: its walls need {len(boxes)} boxes; expected at most {MAX_BOXES}: remove stray pixels, "
            "or reduce the resolution"
        )
    extent = _extent(plan, mask)
    try:
        check_extent(extent)
    except ValueError as error:
        raise FileError(f"{plan.image}: {error}") from error
    return tuple(_wall(box, plan, mask.shape[0], height) for box in boxes), extent


def _occupied(darkness: NDArray[np.float64], plan: FloorPlanFile) -> Mask:
    """Return the pixels that are wall, as the map server of ROS 2 (nav2_map_server) decides."""
    if plan.mode == "raw":
        return np.asarray(np.round((1.0 - darkness) * 255.0) == OCCUPIED)
    return np.asarray((1.0 - darkness if plan.negate else darkness) > plan.occupied_thresh)


def merged(mask: Mask) -> list[Box]:
    """Cover the true pixels of a mask by disjoint boxes: the smaller number of merged rows or merged columns."""
    by_rows = _by_rows(mask)
    by_columns = [(top, left, bottom, right) for left, top, right, bottom in _by_rows(mask.T)]
    return min(by_rows, by_columns, key=len)


def _by_rows(mask: Mask) -> list[Box]:
    """Merge the runs of each row with equal runs in the rows below."""
    boxes: list[Box] = []
    begun: dict[tuple[int, int], int] = {}  # runs of the row above, and the first row that they are in
    steps = np.diff(np.pad(mask.astype(np.int8), ((0, 1), (1, 1))), axis=1)  # an empty last row ends all runs
    for row, step in enumerate(steps):
        runs = zip(np.flatnonzero(step == 1).tolist(), np.flatnonzero(step == -1).tolist(), strict=True)
        goes_on = {run: begun.get(run, row) for run in runs}
        boxes += [(run[0], first, run[1], row) for run, first in begun.items() if run not in goes_on]
        begun = goes_on
    return boxes


def _wall(box: Box, plan: FloorPlanFile, rows: int, height: float) -> Wall:
    left, top, right, bottom = box
    size = plan.resolution
    inside = Pose2((left + right) / 2 * size, (rows - (top + bottom) / 2) * size, 0.0)
    x, y, yaw = Pose2(*plan.origin).compose(inside)
    return Wall("walls", x, y, yaw, (right - left) * size, (bottom - top) * size, height)


def _extent(plan: FloorPlanFile, mask: Mask) -> Extent:
    origin = Pose2(*plan.origin)
    width, height = mask.shape[1] * plan.resolution, mask.shape[0] * plan.resolution
    corners = [origin.compose(Pose2(x, y, 0.0)) for x in (0.0, width) for y in (0.0, height)]
    xs, ys = [corner.x for corner in corners], [corner.y for corner in corners]
    # Rounding must not add a cell to a plan of 6 m.
    return tuple(round(value, 6) for value in (min(xs), min(ys), max(xs), max(ys)))  # type: ignore[return-value]
