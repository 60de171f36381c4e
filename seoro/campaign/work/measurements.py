"""Columns of a row that come from the run: parameters, measurements of robots, samples of items."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from seoro.bridges.wire.outputs import Measurements
from seoro.campaign.space.world_axes import world_number
from seoro.embed.world_settings import WORLD

_NUMBER = re.compile(r"(?<![A-Za-z_\d])-?\d+(\.\d+)?(e[-+]?\d+)?")


def values_of(texts: Mapping[str, str], parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the parameters that vary, in SI base units.

    Args:
        texts: Their values by path, in the notation of the scenario.
        parameters: Chosen values of all parameters; those of invocations are not among them, and stay texts.
    """
    return {path: _value(path, text, parameters) for path, text in texts.items()}


def _value(path: str, text: str, parameters: Mapping[str, Any]) -> object:
    if path.startswith(WORLD):
        number = world_number(text)
        return text if number is None else number
    try:
        return value_at(parameters, path)
    except KeyError:
        return _bare(text)


def value_at(parameters: Mapping[str, Any], path: str) -> Any:
    """Return the value of a parameter, or of a field of one.

    Raises:
        KeyError: The parameter or the field is missing.
    """
    value: Any = parameters
    for name in path.split("."):
        if not isinstance(value, Mapping):
            raise KeyError(path)
        value = value[name]
    return value


def _bare(text: str) -> str:
    """Strip the quotes of a string literal."""
    is_string = len(text) > 1 and text[0] == text[-1] and text[0] in "'\""
    return text[1:-1] if is_string else text


def of_robots(measured: Measurements) -> Iterator[tuple[str, object]]:
    """Yield the measurements of robots and of entities, as `ROBOT.NAME`; parts as `ROBOT.NAME.PART`."""
    for entity, values in {**measured.robots, **measured.entities}.items():
        for name, value in values.model_dump(mode="json").items():
            if isinstance(value, dict):
                yield from ((f"{entity}.{name}.{part}", single) for part, single in value.items())
            else:
                yield f"{entity}.{name}", value


def of_item(record: Mapping[str, Any]) -> Iterator[tuple[str, object]]:
    """Yield the columns of a record of an item: `record.ITEM`, or `cover.ITEM.PART` for combinations."""
    column, value = f"{record['kind']}.{record['item']}", record.get("value")
    if isinstance(value, dict):
        yield from ((f"{column}.{part}", single) for part, single in value.items())
    else:
        yield column, value


def reason_key(reason: str) -> str:
    """Return a reason with `#` for numbers, so that alike failures have the same; names keep their digits."""
    return _NUMBER.sub("#", reason)
