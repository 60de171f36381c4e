"""World files from other files: a map of the map server, a picture of a floor, or a scene, with a TurtleBot 4."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from seoro.files.world_names import PLAN_FILES
from seoro.files.yaml_lines import FileError
from sim_nodes.worlds.parameters import set_parameters

START = "start"  # name of the pose at which robots of such worlds start
DEFAULT_ROBOT = "turtlebot4"


def described(path: Path) -> str:
    """Return the text of a world file for a picture or a scene.

    Raises:
        OSError: The file is missing.
    """
    path.stat()
    if path.suffix.lower() in PLAN_FILES:
        return yaml.safe_dump(_world(path, {"floor_plan": {"image": path.name, "origin": [0.0, 0.0, 0.0]}}))
    return yaml.safe_dump(_world(path, {"scene": path.name}))


def as_world(content: Any, source: str, parameters: str) -> Any:
    """Return the content of a world file with parameters; a map of the map server becomes a world.

    Args:
        content: Content of the file.
        source: Name of the file.
        parameters: See `set_parameters`.

    Raises:
        FileError: A parameter is invalid, or the resolution of a picture is missing.
    """
    path = Path(source)
    if isinstance(content, dict) and {"image", "resolution"} <= content.keys() and "name" not in content:
        content = _world(path, {"floor_plan": path.name})
    try:
        content = set_parameters(content, parameters)
    except FileError as error:
        raise FileError(f"{source}: {error}") from error
    if path.suffix.lower() in PLAN_FILES and "resolution" not in content["floor_plan"]:
        raise FileError(
            f"{source}: missing resolution of the picture [m]; expected `{path.name}?floor_plan.resolution=0.05`"
        )
    return content


def _world(path: Path, surroundings: dict[str, Any]) -> dict[str, Any]:
    name = re.sub(r"[^A-Za-z0-9_-]", "_", path.stem)[:60]
    robot = {"name": DEFAULT_ROBOT, "robot": DEFAULT_ROBOT, "pose": {"at": START}}
    return {
        "name": name if re.match("[A-Za-z]", name) else f"map_{name}",
        **surroundings,
        "robots": [robot],
    }
