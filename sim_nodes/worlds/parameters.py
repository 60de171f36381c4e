"""Parameters of worlds: values of keys in a world file, as in `hall.yaml?generate.seed=3&wall_height=1`."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import unquote

from seoro.files.plain_yaml import read_yaml
from seoro.files.yaml_lines import FileError

MAX_PARAMETERS = 100
KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")
VALUE = re.compile(r"[A-Za-z0-9_+-][A-Za-z0-9_.+-]*")  # numbers, booleans, names, files in the folder of the world


def set_parameters(content: Any, parameters: str) -> Any:
    """Return the content of a world file with other values.

    A key is a path of keys, of names of list items, and of their numbers from 0. Missing mappings are added.

    Args:
        content: Content of the file; it is unchanged.
        parameters: `KEY=VALUE`, joined by `&`.

    Raises:
        FileError: A parameter is invalid, or names an unknown list item.
    """
    given = [each for each in parameters.split("&") if each]
    if len(given) > MAX_PARAMETERS:
        raise FileError(f"found {len(given)} parameters; expected at most {MAX_PARAMETERS}")
    for each in given:
        key, equals, value = (unquote(part) for part in each.partition("="))
        if not equals or not KEY.fullmatch(key) or not VALUE.fullmatch(value):
            raise FileError(
                f"invalid parameter `{each}`; expected KEY=VALUE, such as `generate.seed=3`, with a number, "
                "`true`, `false` or a name as value"
            )
        content = _with(content, key.split("."), read_yaml(value), key)
    return content


def _with(content: Any, path: list[str], value: Any, key: str) -> Any:
    """Return content in which the value at a path is another."""
    if not path:
        return value
    first, *rest = path
    if isinstance(content, list):
        index = _index(content, first, key)
        return [*content[:index], _with(content[index], rest, value, key), *content[index + 1 :]]
    inside = content if isinstance(content, dict) else {}
    return {**inside, first: _with(inside.get(first), rest, value, key)}


def _index(items: list[Any], name: str, key: str) -> int:
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    if name in names:
        return names.index(name)
    if name.isdecimal() and int(name) < len(items):
        return int(name)
    known = ", ".join(str(each) for each in names if each is not None)
    raise FileError(
        f"invalid parameter `{key}`: unknown item `{name}`; expected "
        + (f"a name ({known}), or " if known else "")
        + f"a number below {len(items)}"
    )
