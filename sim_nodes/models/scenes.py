"""Model files with several bodies: scenes, whose bodies are entities of their own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from seoro.deferred import dataclass
from sim_nodes.geometry import Frame
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.settings import FROM_FILE, ModelSettings
from sim_nodes.physics import BodyModel, BodyState, Mjcf

MAX_BODIES = 200  # of a file
LONGEST = 48  # [characters] of the name of a body, so that those of entities can begin with another name
FLOORS = {"plane"}
XACRO = "{http://www.ros.org/wiki/xacro}"


@dataclass(frozen=True)
class SceneBody:
    """A body of a scene.

    Attributes:
        name: Name in the file with letters, digits, `_` and `-` only; unique in the scene.
        model: The body in its own frame.
        state: Its initial state in the frame of the file.
    """

    name: str
    model: BodyModel
    state: BodyState


@dataclass(frozen=True)
class _Body:
    """A body of a file: its URDF, meshes by virtual path, and frame in the file."""

    name: str
    urdf: Any
    meshes: Mapping[str, bytes]
    frame: Frame
    mjcf: Mjcf | None = None
    notes: tuple[str, ...] = ()


def split_scene(
    text: str, files: Mapping[str, bytes], settings: ModelSettings = FROM_FILE
) -> tuple[SceneBody, ...]:
    """Split a scene into bodies that move independently.

    Models of SDF are bodies, and links of theirs that no joint connects. In MJCF, each body at the top that moves
    is one. Bodies on the world that an equality or a tendon connects are one. All that stands still is the body
    `scene`. Floors and lights are left out: planes of the world in MJCF, and static models of planes in SDF.

    Args:
        text: Text of the file in SDF, MJCF or URDF.
        files: Files that it names, by virtual path (`seoro.bridges.model_files`).
        settings: Settings of the reader.

    Returns:
        The bodies, static ones first; none if the file has a floor only.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has unsupported parts.
    """
    return read_bodies(text, files, settings, apart=True)


def read_bodies(
    text: str, files: Mapping[str, bytes], settings: ModelSettings, *, apart: bool
) -> tuple[SceneBody, ...]:
    """Read the bodies of a file; see `split_scene`.

    Args:
        text: Text of the file.
        files: Files that it names, by virtual path.
        settings: Settings of the reader.
        apart: Whether bodies on joints to the world are bodies of their own, and a single model of SDF has its own
            frame. Otherwise, all that hangs on the world is one body.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has unsupported parts.
    """
    from sim_nodes.models.canonical import canonical_model  # noqa: PLC0415 - loads meshes

    found, names = [], _Names()
    for body in _bodies(xml.parse_xml(text), files, apart=apart):
        if settings.decompose and body.mjcf is not None:
            raise xml.invalid("unexpected `decompose` for MJCF; expected a model in URDF or SDF")
        read = canonical_model(body.urdf, body.meshes, settings)
        model = replace(read, mjcf=body.mjcf, notes=(*read.notes, *body.notes))
        place, turn = body.frame
        found.append(SceneBody(names.add(body.name), model, BodyState(place, turn)))
    return tuple(sorted(found, key=lambda body: not body.model.static))


def _bodies(root: Any, files: Mapping[str, bytes], *, apart: bool) -> Iterator[_Body]:
    match root.tag:
        case "robot":
            if any(str(element.tag).startswith(XACRO) for element in root.iter()):
                raise xml.invalid("found macros of xacro in the model; expected a file with the suffix .xacro")
            yield _Body(root.get("name") or "", root, files, xml.ORIGIN)
        case "sdf":
            yield from _sdf_bodies(root, files, apart=apart)
        case "mujoco":
            yield from _mjcf_bodies(root, files, apart=apart)
        case "mujocoinclude":
            raise RequestRefused(
                SpawnResult.UNSUPPORTED_FORMAT,
                "<mujocoinclude> is a part of other models; expected the model that includes it",
            )
        case other:
            raise RequestRefused(
                SpawnResult.UNSUPPORTED_FORMAT,
                f"unknown root element <{other}> of the model; expected <sdf>, <robot> (URDF) or <mujoco> (MJCF)",
            )


def _sdf_bodies(root: Any, files: Mapping[str, bytes], *, apart: bool) -> Iterator[_Body]:
    from sim_nodes.models.sdf import translate_sdf  # noqa: PLC0415
    from sim_nodes.models.sdf_elements import models_of  # noqa: PLC0415

    models = models_of(root, files)
    if apart or len(models) > 1:
        models = [model for model in models if not (model.static and _is_floor(model.element))]
    if len(models) > MAX_BODIES:
        raise xml.invalid(f"found {len(models)} models in the file; expected at most {MAX_BODIES}")
    for model in models:
        for body in translate_sdf(model, files, apart=apart or len(models) > 1):
            yield _Body(body.name, body.urdf, files, body.frame)


def _is_floor(model: Any) -> bool:
    """Whether all solid shapes of an SDF model are planes."""
    shapes = [str(shape.tag) for geometry in model.iterfind("link/collision/geometry") for shape in geometry]
    return bool(shapes) and set(shapes) <= FLOORS


def _mjcf_bodies(root: Any, files: Mapping[str, bytes], *, apart: bool) -> Iterator[_Body]:
    from sim_nodes.models.mjcf import bundle_mjcf  # noqa: PLC0415

    try:
        from sim_nodes.mujoco.scenes import split_mjcf  # noqa: PLC0415
        from sim_nodes.mujoco.to_urdf import urdf_of  # noqa: PLC0415
    except ImportError as error:
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_FORMAT,
            "MJCF files are read by MuJoCo, also for other engines; install it: pip install 'seoro[mujoco]'",
        ) from error
    for piece in split_mjcf(bundle_mjcf(root, files), apart=apart):
        written = urdf_of(piece.model)
        notes = (*piece.notes, *written.notes)
        yield _Body(piece.name, written.urdf, written.meshes, piece.frame, piece.mjcf, notes)


class _Names:
    """Names of the bodies of a scene, as entities may have them."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def add(self, name: str) -> str:
        """Return the nearest valid name that is free, and take it."""
        clean = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_")[:LONGEST]
        clean = clean if re.match(r"[A-Za-z]", clean) else f"body_{clean}".rstrip("_")
        numbered = (f"{clean}_{number}" for number in range(2, len(self._taken) + 3))
        free = next(each for each in (clean, *numbered) if each not in self._taken)
        self._taken.add(free)
        return free
