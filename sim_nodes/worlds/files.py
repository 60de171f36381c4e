"""Lists the files of a world: its own file, and all files that it names.

    python -m sim_nodes.worlds.files WORLD

prints their paths as a JSON list, to copy a world to another machine. As in a node, the world is loaded first,
so that errors in it are reported here.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from seoro.bridges.model_files import gather
from seoro.bridges.xacro_files import split_arguments
from seoro.files.yaml_lines import read_text, read_yaml
from sim_nodes.worlds.loader import WorldError, load_world, read_described


def files_of_world(world: str) -> Iterator[Path]:
    """Yield the files of a world, the world file first.

    Args:
        world: Path of its file, perhaps with parameters.

    Raises:
        WorldError: A file is missing or invalid, or its path is only valid on this machine.
    """
    load_world(world)
    file, path = read_described(world)
    yield path
    if isinstance(file.floor_plan, str):
        plan = _relative_file(path, file.floor_plan)
        if plan != path:  # a map is a world by itself
            yield plan
        yield _relative_file(plan, _named(plan, "image"))
    elif file.floor_plan is not None:
        image = _relative_file(path, file.floor_plan.image)
        if image != path:
            yield image
    if file.scene is not None:
        scene = _relative_file(path, file.scene)
        yield from (each for each in _model_files(scene) if each != path)
    for piece in file.terrain:
        if piece.heightfield is not None:
            yield _relative_file(path, piece.heightfield.image)
    for robot in file.robots:
        if robot.robot.endswith(".yaml"):
            declaration = _relative_file(path, robot.robot)
            yield declaration
            yield from _model_files(_relative_file(declaration, _named(declaration, "urdf")))
    for prop in file.props:
        if prop.model is not None:
            yield from _model_files(_relative_file(path, prop.model))


def _model_files(path: Path) -> Iterator[Path]:
    """Yield a model file, and the files that it names."""
    yield Path(split_arguments(str(path))[0])
    yield from gather(path, expands=True).paths


def _relative_file(path: Path, name: str) -> Path:
    """Return a file that another names. An absolute path is refused: it does not exist on other machines."""
    if Path(name).is_absolute():
        raise WorldError(
            f"absolute path {name} in {path}, which does not exist on other machines; expected a path relative to "
            f"{path.name}"
        )
    return path.parent / name


def _named(path: Path, key: str) -> str:
    """Return the file that another names; it was checked when the world was loaded."""
    content = read_yaml(read_text(path), str(path))
    assert isinstance(content, dict)
    return str(content[key])


def main(arguments: Sequence[str]) -> int:
    """Print the files of a world; returns the exit status."""
    [world] = arguments
    try:
        found = [str(file) for file in files_of_world(world)]
    except WorldError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    sys.stdout.write(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
