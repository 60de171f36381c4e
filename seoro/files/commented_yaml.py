"""YAML files of models, with comments from their docstrings."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any, Final

import yaml
from pydantic import BaseModel

WIDTH: Final = 100  # [characters] of comments

Place = tuple[str, ...]
"""Keys from the root of a file to a value."""

_ENTRY: Final = re.compile(r"^ {4}(\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def described_arguments(docstring: str) -> dict[str, str]:
    """Return the descriptions of the arguments in a docstring, by name."""
    _, _, entries = inspect.cleandoc(docstring).partition("Args:\n")
    return {found[1]: " ".join(found[2].split()) for found in _ENTRY.finditer(f"{entries}\n")}


def commented_yaml(model: BaseModel, notes: Mapping[Place, str], heading: str) -> str:
    """Write the fields of a model that were set as YAML.

    Args:
        model: The model.
        notes: Comments of values, beside those from the docstrings of the models.
        heading: Comment of the file. Its indented lines are not wrapped.
    """
    lines = [*_comment(heading, 0), *_fields(model, (), notes)]
    return "\n".join(lines) + "\n"


def _fields(
    model: BaseModel, above: Place, notes: Mapping[Place, str], *, is_described: bool = True
) -> Iterator[str]:
    meanings = described_arguments(type(model).__doc__ or "") if is_described else {}
    for name, field in type(model).model_fields.items():
        if name in model.model_fields_set:
            key = field.alias or name
            value, meaning = getattr(model, name), meanings.get(name, "")
            yield from _entry((*above, key), value, meaning, notes, is_described=is_described)


def _entry(
    place: Place, value: Any, meaning: str, notes: Mapping[Place, str], *, is_described: bool
) -> Iterator[str]:
    depth = len(place) - 1
    for text in (meaning, notes.get(place, "")):
        yield from _comment(text, depth)
    key = f"{'  ' * depth}{_scalar(place[-1])}:"
    match value:
        case BaseModel():
            yield key
            yield from _fields(value, place, notes, is_described=is_described)
        case Mapping() if value:
            yield key
            for index, (name, each) in enumerate(value.items()):  # the first one is described
                yield from _entry((*place, name), each, "", notes, is_described=is_described and not index)
        case _:
            yield f"{key} {_scalar(value)}"


def _comment(text: str, depth: int) -> Iterator[str]:
    margin = f"{'  ' * depth}# "
    for line in text.splitlines():
        if line.startswith(" "):
            yield f"{margin}{line}"
        else:
            yield from textwrap.wrap(line, WIDTH, initial_indent=margin, subsequent_indent=margin)


def _scalar(value: Any) -> str:
    """Write a value without models in one line."""
    plain = list(value) if isinstance(value, tuple) else dict(value) if isinstance(value, Mapping) else value
    text: str = yaml.safe_dump(plain, default_flow_style=True, width=1 << 20, allow_unicode=True)
    return text.removesuffix("\n").removesuffix("\n...")
