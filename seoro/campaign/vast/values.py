"""Values and search spaces of RoboVAST files, in the notation of scenarios."""

from __future__ import annotations

import json
from typing import Final

from seoro.campaign.vast.schema import BoolDimension, ChoiceDimension, Dimension, IntDimension
from seoro.lang.frozen import Value

MOST_STEPS: Final = 1000  # values of a dimension with steps
NUMBERS: Final = ("float", "int", "uint")


def literal(value: object, type_name: str) -> str | None:
    """Return a value in the notation of scenarios; None if a parameter of this type cannot have it.

    Args:
        value: Value of the file.
        type_name: Type of the parameter: `string`, `float`, `int`, `uint`, `bool`, or another one.
    """
    match type_name, value:
        case "bool", bool():
            return "true" if value else "false"
        case "float", int() | float() if not isinstance(value, bool):
            return repr(float(value))
        case "int" | "uint", int() if not isinstance(value, bool):
            return str(value)
        case "string", bool() | int() | float() | str():
            return json.dumps(str(value), ensure_ascii=False)
        case _:
            return None


class Range(Value):
    """Values of a parameter that varies.

    Args:
        container: List or range in the notation of scenarios, of `type_name`.
        type_name: Type of its values.
    """

    container: str
    type_name: str


def listed(values: object, type_name: str) -> Range | None:
    """Return listed values of a parameter; None for other data, or if one does not fit the type."""
    if not isinstance(values, list) or not values:
        return None
    texts = [literal(value, type_name) for value in values]
    return None if None in texts else Range(f"[{', '.join(filter(None, texts))}]", type_name)


def bounded(low: object, high: object, type_name: str) -> Range | None:
    """Return the bounds of a number; None for parameters of other types, also strings."""
    ends = [literal(low, type_name), literal(high, type_name)]
    return Range(f"[{ends[0]}..{ends[1]}]", type_name) if type_name in NUMBERS and None not in ends else None


def range_of(dimension: Dimension, type_name: str) -> Range | None:
    """Return the values of a dimension, for a parameter of a type; None if they do not fit the type."""
    match dimension:
        case ChoiceDimension(values=values):
            return listed(values, type_name)
        case BoolDimension():
            return listed([False, True], type_name)
        case IntDimension(low=low, high=high, step=int(step)) if step > 1 and (high - low) // step < MOST_STEPS:
            return listed(list(range(low, high + 1, step)), type_name)
        case _:
            return bounded(dimension.low, dimension.high, type_name)


def own_type(dimension: Dimension) -> str:
    """Return the type of a dimension itself."""
    if isinstance(dimension, ChoiceDimension):
        numbers = [isinstance(value, int | float) and not isinstance(value, bool) for value in dimension.values]
        return "float" if all(numbers) else "string"
    return dimension.type
