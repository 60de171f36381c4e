"""Writes the JSON Schemas of files from their models: `python -m tests.tools.json_schemas`.

They have draft 7, which editors know best. Rules between the values of several keys are not in them.
"""

from __future__ import annotations

import argparse
import inspect
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from seoro.bridges.ros2.robots.profile import Profile
from seoro.cli.campaign_file import is_setting
from seoro.cli.campaign_keys import CampaignKeys
from seoro.cli.main import command_parser
from seoro.executor.limits import Policy
from seoro.files import schemas
from seoro.files.field_meanings import field_meanings
from seoro.files.key_rules import WithKeyRules
from seoro.lab.schema import LabFile
from seoro.security.keys.roles import PEOPLE
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.derive.complete import JOINT_DRIVES, MOBILE_DRIVES
from sim_nodes.robots.derive.mounting import MountingDeclaration
from sim_nodes.worlds.schema import WorldFile

Schema = dict[str, Any]

DRAFT: Final = "http://json-schema.org/draft-07/schema#"
_LOADED: Final = ("source", "meshes", "native", "notes")  # of robots: seoro fills them from the model
_PARTLY: Final = ("mobile", "arm")  # of robots: with `drive`, missing keys below are taken from the model


class _Generator(GenerateJsonSchema):
    """Adds the meanings of fields, in the keywords of draft 7."""

    def __init__(self, *_: Any, **__: Any) -> None:
        super().__init__(by_alias=True, ref_template="#/definitions/{model}")

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Return False: titles would repeat the keys."""
        return False

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        """Return the schema of a model."""
        found, model = super().model_schema(schema), schema["cls"]
        found.pop("title", None)
        found["description"] = (inspect.getdoc(model) or "").partition("\n\n")[0].replace("\n", " ")
        if issubclass(model, WithKeyRules) and model.key_rules:
            found["allOf"] = [rule.schema for rule in model.key_rules]
        meanings = field_meanings(model)
        for name, field in model.model_fields.items():
            part = found["properties"][field.alias or name]
            if name in meanings:
                part["description"] = meanings[name]
            elif "$ref" not in json.dumps(part):
                part.setdefault("description", found["description"])
            if part.get("default", ...) is None:
                del part["default"]
        return found


def json_schema(name: str) -> Schema:
    """Return the schema of a kind of files."""
    title = schemas.SCHEMAS[name].partition(",")[0]
    return {"$schema": DRAFT, "title": f"{title[0].upper()}{title[1:]} of seoro", **_SCHEMAS[name]()}


def text_of(name: str) -> str:
    """Return the text of the file with a schema."""
    return json.dumps(json_schema(name), indent=1, ensure_ascii=False) + "\n"


def _of(model: type[BaseModel]) -> Schema:
    found = model.model_json_schema(schema_generator=_Generator)
    definitions = found.pop("$defs", {})
    if definitions:
        found["definitions"] = definitions
    for each in (found, *definitions.values()):
        for part in each.get("properties", {}).values():
            if meaning := _meaning_below(part, definitions):
                part.setdefault("description", meaning)
    converted: Schema = _draft_7(found)
    return converted


def _meaning_below(part: Any, definitions: Mapping[str, Schema]) -> str | None:
    """Return the description of the part, or of the first part in it that has one: of items, for example."""
    if not isinstance(part, dict):
        return None
    if "description" in part:
        return str(part["description"])
    inner = [*part.get("anyOf", ()), *part.get("oneOf", ()), part.get("items"), part.get("additionalProperties")]
    if "$ref" in part:
        inner.append(definitions[part["$ref"].rpartition("/")[2]])
    return next(filter(None, (_meaning_below(each, definitions) for each in inner)), None)


def _draft_7(value: Any) -> Any:
    """Replace the keywords of newer drafts."""
    if isinstance(value, list):
        return [_draft_7(each) for each in value]
    if not isinstance(value, dict):
        return value
    found = {key: _draft_7(each) for key, each in value.items()}
    if isinstance(items := found.pop("prefixItems", None), list):
        found |= {"items": items, "additionalItems": False}
    if "$ref" in found and len(found) > 1:  # draft 7 ignores what stands beside a reference
        found["allOf"] = [{"$ref": found.pop("$ref")}]
    if "patternProperties" in found:  # other names are invalid
        found.setdefault("additionalProperties", False)
    found.pop("discriminator", None)  # of OpenAPI
    return found


def _campaign() -> Schema:
    """Return the schema of campaign files, whose further keys are options of the command."""
    found = _of(CampaignKeys)
    found["additionalProperties"] = False
    for action in _options(command_parser(["campaign", "run"]), "campaign", "run"):
        name = action.option_strings[-1].removeprefix("--")
        if is_setting(name):
            key = name.replace("-", "_")
            found["properties"].setdefault(key, {**_value_of(action), "description": str(action.help)})
    return found


def _options(parser: argparse.ArgumentParser, *commands: str) -> Iterator[argparse.Action]:
    for command in commands:
        below = next(each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
        parser = below.choices[command]
    yield from (each for each in parser._actions if each.option_strings and each.help != argparse.SUPPRESS)


def _value_of(action: argparse.Action) -> Schema:
    if action.nargs == 0:
        return {"type": "boolean"}
    if action.choices is not None:
        return {"enum": list(action.choices)}
    plain: Schema = {"type": ["string", "number", "boolean"]}
    if isinstance(action, argparse._AppendAction):
        return {"anyOf": [plain, {"type": "array", "items": plain}]}
    return plain


def _policy() -> Schema:
    found = _of(Policy)
    found["properties"]["roles"]["propertyNames"] = {"enum": [role.value for role in PEOPLE]}
    return found


def _robot() -> Schema:
    """Return the schema of declarations of robots: complete ones, and those with `drive`."""
    found, mounting = _of(RobotDeclaration), _of(MountingDeclaration)
    properties: Schema = {}
    definitions = {**found["definitions"], **mounting.pop("definitions", {}), "MountingDeclaration": mounting}
    properties["urdf"] = {
        "type": "string",
        "description": "Model of the robot, relative to the folder of this file: URDF, xacro, SDF or MJCF.",
    }
    properties["drive"] = {
        "enum": [*MOBILE_DRIVES, *JOINT_DRIVES],
        "description": "Kind of drive. With it, all values that are missing here are taken from the model.",
    }
    properties["home"] = {
        "type": "object",
        "additionalProperties": {"type": "number"},
        "description": "Initial positions of joints [rad], [m], by joint or pattern; with `drive`.",
    }
    properties["mounted"] = {
        "allOf": [{"$ref": "#/definitions/MountingDeclaration"}],
        "description": "Robot that is mounted on the base; with `drive`.",
    }
    for key, value in found["properties"].items():
        if key not in _LOADED:
            properties.setdefault(key, value)
    for key in _PARTLY:
        _make_optional(properties[key], definitions)
    return {**found, "properties": properties, "required": ["urdf"], "definitions": definitions}


def _make_optional(part: Any, definitions: Mapping[str, Schema]) -> None:
    """Remove `required` from a part and those below it, but not from the items of lists."""
    if isinstance(part, list):
        for each in part:
            _make_optional(each, definitions)
    elif isinstance(part, dict):
        part.pop("required", None)
        if "$ref" in part:
            _make_optional(definitions[part["$ref"].rpartition("/")[2]], definitions)
        for key in ("anyOf", "allOf", "oneOf"):
            _make_optional(part.get(key), definitions)
        _make_optional(list(part.get("properties", {}).values()), definitions)


_SCHEMAS: Final[Mapping[str, Callable[[], Schema]]] = {
    "campaign": _campaign,
    "lab": lambda: _of(LabFile),
    "policy": _policy,
    "profile": lambda: _of(Profile),
    "robot": _robot,
    "world": lambda: _of(WorldFile),
}


if __name__ == "__main__":
    for name in _SCHEMAS:
        folder = Path(inspect.getfile(schemas)).parent
        (folder / schemas.file_name(name)).write_text(text_of(name), encoding="utf-8")
