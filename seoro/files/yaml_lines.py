"""YAML files of users, with line numbers in errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError

from seoro.errors import UsageError
from seoro.files.inputs import Kind, failure_reason, read_input_text
from seoro.files.plain_yaml import load_yaml

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

M = TypeVar("M", bound=BaseModel)


class FileError(Exception):
    """A file cannot be read, or is invalid."""


def read_text(path: Path, kind: Kind = Kind.SETTINGS) -> str:
    """Read the text of a file.

    Raises:
        FileError: The file cannot be read, is not regular, or is too large.
    """
    try:
        return read_input_text(path, kind)
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"cannot read {path}: {failure_reason(error)}") from error


class Lines:
    """Locations of the values in a YAML file.

    Args:
        text: Text of the file, valid YAML.
        source: Name of the file in messages.
    """

    def __init__(self, text: str, source: str) -> None:
        self._text = text
        self._source = source

    @cached_property
    def _root(self) -> yaml.Node | None:
        return yaml.compose(self._text, yaml.SafeLoader)  # a second parse, needed for messages only

    def at(self, place: Sequence[int | str]) -> str:
        """Return the location of a value, or of its nearest existing parent, such as `hall.yaml:7`."""
        return f"{self._source}:{self.line(place)}"

    def line(self, place: Sequence[int | str]) -> int:
        """Return the line of a value, or of its nearest existing parent."""
        node, mark = self._root, None if self._root is None else self._root.start_mark
        for part in place:
            match node:
                case yaml.MappingNode():
                    found = [pair for pair in node.value if pair[0].value == str(part)]
                    if not found:
                        break
                    key, node = found[-1]
                    mark = key.start_mark
                case yaml.SequenceNode() if isinstance(part, int) and part < len(node.value):
                    node = node.value[part]
                    mark = node.start_mark
                case _:
                    break
        return 1 if mark is None else mark.line + 1

    def before(self, message: str) -> str:
        """Prefix a message that begins with a place, such as `robots.0.pose: `, with its location."""
        place = message.partition(": ")[0].split(".")
        return f"{self.at([int(part) if part.isdecimal() else part for part in place])}: {message}"


def read_yaml(text: str, source: str) -> Any:
    """Parse a YAML file.

    Raises:
        FileError: The YAML is invalid; the message has the file and the line.
    """
    try:
        return load_yaml(text, references=True)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        what = " ".join(part for part in (error.context, error.problem) if part)
        raise FileError(f"{source}:{mark.line + 1 if mark else 1}: invalid YAML: {what}") from error
    except yaml.YAMLError as error:
        raise FileError(f"{source}: invalid YAML: {error}") from error


def read_settings(path: Path, model: type[M]) -> tuple[M, Lines]:
    """Read and validate a YAML file.

    Args:
        path: The file.
        model: Model of its content.

    Returns:
        The content, and the lines of the file.

    Raises:
        UsageError: The file cannot be read or is invalid; the message has the file and the lines.
    """
    try:
        text = read_text(path)
        content, lines = read_yaml(text, str(path)), Lines(text, str(path))
        return validate(model, content, lines), lines
    except FileError as error:
        raise UsageError(str(error)) from error


def validate(model: type[M], content: object, lines: Lines) -> M:
    """Validate the content of a file.

    Raises:
        FileError: The content is invalid; the message lists all errors with their lines.
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise FileError(_describe_errors(error, lines, model)) from error


def _describe_errors(error: ValidationError, lines: Lines, model: type[BaseModel]) -> str:
    """Describe all errors of a file, with the line and the place of each.

    Args:
        error: Validation error.
        lines: Lines of the file.
        model: Model of the file, with the known keys.
    """
    return "; ".join(
        f"{lines.at(item['loc'])}: {'.'.join(map(str, item['loc'])) or 'the file'}: {_described(item, model)}"
        for item in error.errors()
    )


def _described(item: ErrorDetails, model: type[BaseModel]) -> str:
    if item["type"] == "too_long":
        return "found {actual_length} items, expected {max_length} at most".format_map(item["ctx"])
    if item["type"] != "extra_forbidden":
        return item["msg"]
    from difflib import get_close_matches  # noqa: PLC0415 - slow to load, and only needed for errors

    *parents, key = item["loc"]
    known = sorted(_keys_at(model, parents))
    close = get_close_matches(str(key), known, n=1)
    hint = f"did you mean `{close[0]}`?" if close else f"keys: {', '.join(known)}" if known else ""
    return f"unknown key `{key}`{f' ({hint})' if hint else ''}"


def _keys_at(model: type[BaseModel], place: Sequence[int | str]) -> set[str]:
    """Return the known keys of the mapping at a place; may be empty."""
    models = {model}
    for part in place:
        types: set[Any] = set()
        for each in models:
            field = each.model_fields.get(str(part))
            # Other parts are keys of mappings, indices, or tags of unions.
            types |= _models_in(field.annotation) if field is not None else {each}
        models = types
    return {field.alias or name for each in models for name, field in each.model_fields.items()}


def _models_in(annotation: Any) -> set[Any]:
    """Return the models in an annotation such as `dict[str, Robot] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return {annotation}
    return {found for argument in get_args(annotation) for found in _models_in(argument)}
