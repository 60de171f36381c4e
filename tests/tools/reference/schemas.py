"""Keys of files, from their models."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from seoro.bridges.ros2.robots.profile import Profile
from seoro.cli.campaign_keys import CampaignKeys
from seoro.files.field_meanings import field_meanings
from seoro.lab.schema import LabFile
from seoro.lang.projects import SETTINGS, TEST, TEST_SETTINGS
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.worlds.schema import WorldFile
from tests.tools.reference.tables import cell, code, table


def campaign_file() -> str:
    """Return the keys of a campaign file."""
    return _keys(CampaignKeys)


def lab_file() -> str:
    """Return the keys of a lab file."""
    return _keys(LabFile)


def world_file() -> str:
    """Return the keys of a world file."""
    return _keys(WorldFile)


def robot_file() -> str:
    """Return the keys of a robot's declaration."""
    return _keys(RobotDeclaration)


def profile_file() -> str:
    """Return the keys of a robot profile."""
    return _keys(Profile)


def project_settings() -> str:
    """Return the settings of projects."""
    settings = {**SETTINGS, **{f"{TEST}.{key}": setting for key, setting in TEST_SETTINGS.items()}}
    rows = ((code(key), cell(setting.meaning), code(setting.option)) for key, setting in settings.items())
    return table(("setting", "meaning", "option"), rows)


def _keys(model: type[BaseModel]) -> str:
    return table(("key", "type", "default", "meaning"), _rows(model, "", []))


def _rows(model: type[BaseModel], path: str, above: list[type]) -> Iterator[tuple[str, str, str, str]]:
    """Yield a row for each key, followed by the rows of the keys below it."""
    meanings = field_meanings(model)
    for name, field in model.model_fields.items():
        key, parts = path + (field.alias or name), list(_parts(field.annotation))
        default = "required" if field.is_required() else "" if parts else _default(field)
        meaning = meanings.get(name) or next((inspect.getdoc(part) or "" for part, _ in parts), "")
        yield code(key), _type(field), default, meaning.partition("\n\n")[0]
        for part, suffix in parts:
            if part not in above:
                yield from _rows(part, f"{key}{suffix}.", [*above, model])


def _parts(annotation: Any, suffix: str = "") -> Iterator[tuple[type[BaseModel], str]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation, suffix
        return
    origin = typing.get_origin(annotation)
    name = getattr(origin, "__name__", "")
    added = "[]" if name in ("tuple", "list", "Sequence") else ".NAME" if name in ("dict", "Mapping") else ""
    for part in typing.get_args(annotation):
        yield from _parts(part, suffix + added)


def _default(field: FieldInfo) -> str:
    value = field.default
    if value is PydanticUndefined or value is None or value in ((), ""):
        return ""
    return code(str(value).lower() if isinstance(value, bool) else str(value))


def _type(field: FieldInfo) -> str:
    return cell(", ".join([_shown(field.annotation), *_bounds(field.metadata)]))


def _bounds(metadata: Iterable[Any]) -> list[str]:
    return [
        f"{sign} {getattr(each, name):g}"
        for each in metadata
        for name, sign in (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))
        if isinstance(getattr(each, name, None), int | float)
    ]


def _shown(annotation: Any) -> str:
    if isinstance(annotation, type) and not typing.get_args(annotation):
        return "mapping" if issubclass(annotation, BaseModel) else _NAMES.get(annotation, annotation.__name__)
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    name = getattr(origin, "__name__", str(origin))
    if name == "Annotated":
        metadata = [part for each in arguments[1:] for part in getattr(each, "metadata", [each])]
        return ", ".join([_shown(arguments[0]), *_bounds(metadata)])
    if name == "Literal":
        return " or ".join(code(str(each).lower() if isinstance(each, bool) else str(each)) for each in arguments)
    if name in ("tuple", "list", "Sequence", "frozenset"):
        parts = [each for each in arguments if each is not Ellipsis]
        is_list = len(parts) < len(arguments) or len(parts) == 1
        return f"list of {_shown(parts[0])}" if is_list else f"list of {len(parts)} times {_shown(parts[0])}"
    if name in ("dict", "Mapping"):
        return "mapping by name"
    return " or ".join(dict.fromkeys(_shown(each) for each in arguments if each is not type(None)))


_NAMES = {str: "text", float: "number", int: "integer", bool: "true or false"}
