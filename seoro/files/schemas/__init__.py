"""JSON Schemas (draft 7) of the YAML files of users. `make goldens` writes them from the models of the files."""

from __future__ import annotations

from importlib import resources
from typing import Final

SCHEMAS: Final = {
    "campaign": "campaign file, for `seoro campaign run`",
    "lab": "lab file, for `--lab`",
    "policy": "policy of an executor, for `seoro serve --policy`",
    "profile": "robot profile, for `seoro bridge ros2 --robot`",
    "robot": "robot declaration, for `robot` of a world file",
    "world": "world file, for `--world`",
}
"""Kinds of files by name, with their use."""


def file_name(name: str) -> str:
    """Return the name of the file with a schema."""
    return f"{name}.schema.json"


def schema_text(name: str) -> str:
    """Return a schema as JSON.

    Args:
        name: One of `SCHEMAS`.
    """
    return resources.files(__package__).joinpath(file_name(name)).read_text(encoding="utf-8")
