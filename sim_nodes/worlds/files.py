"""Which files a world consists of: its own, and all that it names.

    python -m sim_nodes.worlds.files WORLD.yaml

prints their paths as a JSON list, for those who send a world elsewhere. The world is loaded, as a node would do
it, so that what is wrong with it is said here.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from sim_nodes.files import read_text, read_yaml
from sim_nodes.worlds.loader import WorldError, load_world, read_world_file


def files_of_world(path: Path) -> Iterator[Path]:
    """The files of a world, the world file first.

    Raises:
        WorldError: One of them is not there, or is wrong, or is named in a way that holds on this machine only.
    """
    load_world(str(path))
    yield path
    file, _ = read_world_file(read_text(path), str(path))
    if isinstance(file.floor_plan, str):
        plan = _beside(path, file.floor_plan)
        yield plan
        yield _beside(plan, _named(plan, "image"))
    elif file.floor_plan is not None:
        yield _beside(path, file.floor_plan.image)
    for robot in file.robots:
        if robot.robot.endswith(".yaml"):
            declaration = _beside(path, robot.robot)
            yield declaration
            yield _beside(declaration, _named(declaration, "urdf"))
    for prop in file.props:
        if prop.model is not None:
            yield _beside(path, prop.model)


def _beside(path: Path, name: str) -> Path:
    """A file that another names. On another machine, nodes look for it there: nothing finds an absolute path."""
    if Path(name).is_absolute():
        raise WorldError(
            f"{path} names {name} by an absolute path, which is not there on another machine: name it relative to "
            f"{path.name}"
        )
    return path.parent / name


def _named(path: Path, key: str) -> str:
    """The file that another names, which was checked when the world was loaded."""
    content = read_yaml(read_text(path), str(path))
    assert isinstance(content, dict)
    return str(content[key])


def main(arguments: Sequence[str]) -> int:
    """Print the files of a world."""
    [path] = arguments
    try:
        found = [str(file) for file in files_of_world(Path(path))]
    except WorldError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    sys.stdout.write(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
