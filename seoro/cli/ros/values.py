"""Messages as YAML, JSON and tables."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from seoro.errors import UsageError
from seoro.files.plain_yaml import read_yaml
from seoro.text.printable import printable

MANY = 16  # shown elements of a list
LONG = 200  # shown characters of a text


def read_words(words: Sequence[str]) -> tuple[str | None, Mapping[str, Any]]:
    """Read the type and the value of a message, as `ros2` has them; both may be missing.

    Args:
        words: Arguments after the name of the topic, service or action.

    Returns:
        The type if it is given, and the fields of the value.

    Raises:
        UsageError: There are more words, or the value is not a mapping.
    """
    match words:
        case []:
            return None, {}
        case [word] if _TYPE.fullmatch(word):
            return word, {}
        case [value]:
            return None, _read_value(value)
        case [type_name, value] if _TYPE.fullmatch(type_name):
            return type_name, _read_value(value)
    unexpected = words[0] if len(words) == 2 else words[2]
    raise UsageError(
        f"unexpected argument {unexpected!r}: expected [TYPE] VALUE", help=f"quote the value; {_EXAMPLE}"
    )


_TYPE = re.compile(r"[A-Za-z]\w*(/(msg|srv|action))?/[A-Za-z]\w*")


def _read_value(text: str) -> Mapping[str, Any]:
    """Parse the fields of a message from YAML or JSON; an empty text gives no fields.

    Raises:
        UsageError: The text is not a mapping.
    """
    try:
        value = read_yaml(text) if text.strip() else {}
    except ValueError as error:
        raise UsageError(f"invalid value: {error}", help=_EXAMPLE) from error
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise UsageError(f"invalid value {text!r}: expected a mapping of fields", help=_EXAMPLE)
    return value


_EXAMPLE = "write it as YAML: '{linear: {x: 0.2}, angular: {z: 0.1}}'"


def as_yaml(value: Any, *, full: bool) -> str:
    """Format a value as YAML; long lists and texts are shortened unless `full`."""
    if not isinstance(value, dict | list):
        return _scalar(value if full else _shortened(value))
    shown = value if full else _shortened(value)
    text: str = yaml.dump(
        shown, Dumper=_Dumper, sort_keys=False, default_flow_style=False, allow_unicode=True, width=math.inf
    )
    return text.rstrip("\n")


def _scalar(value: Any) -> str:
    return printable(value) if isinstance(value, str) else json.dumps(value)


def as_json(value: Any) -> str:
    """Format a value as JSON in one line; NaN and infinity become null."""
    return json.dumps(_finite(value), ensure_ascii=False)


def _finite(value: Any) -> Any:
    match value:
        case dict():
            return {name: _finite(each) for name, each in value.items()}
        case list():
            return [_finite(each) for each in value]
        case float() if not math.isfinite(value):
            return None
        case _:
            return value


def _shortened(value: Any) -> Any:
    match value:
        case dict():
            return {name: _shortened(each) for name, each in value.items()}
        case list() if len(value) > MANY:
            return [*map(_shortened, value[:MANY]), f"... {len(value)} in all"]
        case list():
            return [_shortened(each) for each in value]
        case str() if len(value) > LONG:
            return f"{value[:LONG]}... {len(value)} characters in all"
        case _:
            return value


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        """Write repeated values in full."""
        return True


def _represent_list(dumper: _Dumper, values: list[Any]) -> yaml.SequenceNode:
    """Write lists of scalars in one line, other lists in blocks."""
    is_flat = not any(isinstance(each, dict | list) for each in values)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", values, flow_style=is_flat)


_Dumper.add_representer(list, _represent_list)


def count_of(number: int, what: str) -> str:
    """Format a number of things: `1 publisher`, `2 publishers`, `no publisher`."""
    return f"{number or 'no'} {what}{'s' if number > 1 else ''}"
