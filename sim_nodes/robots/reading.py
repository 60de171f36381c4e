"""Reads declarations of robots and the URDF files that they name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.files.yaml_lines import FileError, Lines, read_text, read_yaml, validate
from sim_nodes.files import bundled_names
from sim_nodes.models import parse_model
from sim_nodes.models.xml_reading import invalid
from sim_nodes.physics import BodyModel
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.references.catalogue import available_references, find_reference, model_folder
from sim_nodes.robots.urdf_check import check_urdf

DECLARATIONS = (".yaml", ".yml")


def available_robots() -> tuple[str, ...]:
    """Return the names of the robot kinds that come with the node, and of those by reference."""
    return (*bundled_names(__package__), *available_references())


@cache
def load_robot(model: str) -> RobotDeclaration:
    """Load the declaration of one of `available_robots()`.

    Raises:
        FileError: The package with its model is not installed.
    """
    if model in available_references():
        reference = find_reference(model)
        return read_robot(reference.path, model_folder(reference))
    return read_robot(Path(__file__).parent / f"{model}.yaml")


def read_robot(path: Path, models: Path | None = None) -> RobotDeclaration:
    """Read a robot declaration and the model that it names.

    Short declarations, those with `drive`, are completed from the model.

    Args:
        path: The declaration.
        models: Folder that the name of the model starts from; None for that of the declaration.

    Raises:
        FileError: A file is unreadable or invalid, or the URDF does not fit the declaration.
    """
    text = read_text(path)
    content = read_yaml(text, str(path))
    if not isinstance(content, dict) or not isinstance(content.get("urdf"), str):
        raise FileError(f"{path}: missing `urdf`; expected a file relative to its folder")
    try:
        found = gather((models or path.parent) / content["urdf"], expands=True)
    except InvalidModel as error:
        raise FileError(str(error)) from error
    try:
        model = parse_model(found.text, found.files)
        assert model.urdf is not None
        urdf = model.urdf
        content.pop("reference", None)
        content |= {"meshes": tuple(urdf.meshes.items()), "notes": model.notes}
        if model.mjcf is not None:
            from sim_nodes.robots.derive.native import without_world  # noqa: PLC0415 - other worlds start sooner

            urdf = without_world(urdf, fixed=content.get("drive") == "arm" or bool(content.get("fixed")))
            if "mounted" not in content:
                content["native"] = {"text": model.mjcf.text, "assets": tuple(model.mjcf.assets.items())}
        if "drive" in content:
            from sim_nodes.robots.derive.complete import complete  # noqa: PLC0415 - as above

            content = complete(content, urdf, found.text, _carried(content, path.parent), _keyframes(model))
        else:
            source = found.text if "<robot" in found.text else urdf.text
            content |= {"source": source, "urdf": urdf.text}
        declaration = validate(RobotDeclaration, content, Lines(text, str(path)))
        check_urdf(declaration)
    except RequestRefused as error:
        where = f" (line {line})" if (line := line_of(found.text, error.message)) is not None else ""
        raise FileError(f"the URDF of {path}{where}: {error.message}") from error
    return declaration


def _keyframes(model: BodyModel) -> Mapping[str, Mapping[str, float]]:
    """Return the keyframes of a model in MJCF: positions by joint, by name."""
    if model.mjcf is None:
        return {}
    from sim_nodes.mujoco.native import keyframes_of  # noqa: PLC0415 - MuJoCo has read the model

    return keyframes_of(model.mjcf)


def _carried(content: Mapping[str, object], folder: Path) -> RobotDeclaration | None:
    """Return the robot that is mounted on the robot of a short declaration; None without one."""
    if "mounted" not in content:
        return None
    from sim_nodes.robots.derive.mounting import read_mounting  # noqa: PLC0415 - as above

    robot = read_mounting(content).robot
    if robot.endswith(DECLARATIONS):
        return read_robot(folder / robot)
    if robot not in available_robots():
        raise invalid(
            f"unknown `mounted.robot` {robot!r}; expected {name_list(available_robots())}, or a .yaml file"
        )
    return load_robot(robot)


def line_of(urdf: str, message: str) -> int | None:
    """Return the first line of a URDF with the element named in a message; None without one."""
    found = re.search(r"<(\w+) name='([^']*)'>", message)
    if found is None:
        return None
    tag, name = map(re.escape, found.groups())
    there = re.search(rf"<{tag}\b[^>]*\bname\s*=\s*[\"']{name}[\"']", urdf)
    return None if there is None else urdf.count("\n", 0, there.start()) + 1
