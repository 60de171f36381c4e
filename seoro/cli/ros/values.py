"""Messages as people read and write them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from seoro.errors import InvalidUse
from seoro.plain_yaml import read_yaml
from seoro.terminal_text import printable

MANY = 16  # elements of a list that are shown
LONG = 200  # characters of a text that are shown


def read_value(text: str) -> Mapping[str, Any]:
    """The members that a text gives, as YAML or JSON; an empty text gives none.

    Raises:
        InvalidUse: It is no mapping.
    """
    try:
        value = read_yaml(text) if text.strip() else {}
    except ValueError as error:
        raise InvalidUse(f"the value cannot be read: {error}", help=_EXAMPLE) from error
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise InvalidUse(f"a message is a mapping of its members, not {text!r}", help=_EXAMPLE)
    return value


_EXAMPLE = "write it as YAML: '{linear: {x: 0.2}, angular: {z: 0.1}}'"


def as_yaml(value: Any, *, full: bool) -> str:
    """A value as YAML; long lists and texts are cut off unless it is to be `full`."""
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
    """A value as JSON, in one line; numbers that JSON does not have are null."""
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
        """Write what occurs twice twice."""
        return True


def _represent_list(dumper: _Dumper, values: list[Any]) -> yaml.SequenceNode:
    """Numbers and texts in one line, and what has members below one another."""
    is_flat = not any(isinstance(each, dict | list) for each in values)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", values, flow_style=is_flat)


_Dumper.add_representer(list, _represent_list)


def table(rows: Sequence[Sequence[str]], indent: str = "  ") -> str:
    """Rows as lines, with their columns below one another."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(f"{indent}{line}".rstrip() for line in lines)


def print_types(found: Mapping[str, Sequence[str]], *, in_json: bool) -> None:
    """Print what there is, by names, with its types."""
    if in_json:
        print(as_json({name: list(types) for name, types in found.items()}))
    elif found:
        print(table([[name, ", ".join(types)] for name, types in found.items()], indent=""))


def counted(number: int, what: str) -> str:
    """A number of things: `1 publisher`, `2 publishers`, `no publisher`."""
    return f"{number or 'no'} {what}{'s' if number > 1 else ''}"
