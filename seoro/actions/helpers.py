"""`osc.helpers`: actions, and the methods of its struct `common`."""

from __future__ import annotations

import operator as operators
from collections.abc import Callable, Mapping
from typing import Any

from seoro.errors import ActionFailed, InvalidUse
from seoro.lang.plan import PrimitiveType, ValueType
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.method_context import MethodContext
from seoro.runtime.values import Variable, wrap_int, wrap_uint

_RELATIONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "==": operators.eq,
    "!=": operators.ne,
    "<": operators.lt,
    "<=": operators.le,
    ">": operators.gt,
    ">=": operators.ge,
}


@action("log")
async def log(ctx: ActionContext, msg: object) -> None:
    """Write a message into the trace."""
    ctx.log(str(msg))


@action("increment")
async def increment(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Add one to a variable that holds a number."""
    ctx.update(target_variable, lambda value: _kept(value + 1, target_variable.type))


@action("decrement")
async def decrement(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Subtract one from a variable that holds a number."""
    ctx.update(target_variable, lambda value: _kept(value - 1, target_variable.type))


def _kept(value: float, type_: ValueType) -> float:
    """A number as a variable of a type holds it: whole ones have 64 bits."""
    if not isinstance(value, int):
        return value
    return wrap_uint(value) if type_ == PrimitiveType("uint") else wrap_int(value)


@action("compare")
async def compare(ctx: ActionContext, left_value: object, operator: str, right_value: object) -> None:
    """Compare two values by `==`, `!=`, `<`, `<=`, `>` or `>=`; it fails if that is not true of them."""
    if operator not in _RELATIONS:
        raise ActionFailed(f"there is no operator `{operator}`; there are {', '.join(_RELATIONS)}")
    try:
        is_true = _RELATIONS[operator](left_value, right_value)
    except TypeError:
        raise ActionFailed(f"`{left_value}` and `{right_value}` have no order") from None
    if not is_true:
        raise ActionFailed(f"`{left_value} {operator} {right_value}` is not true")


def get_scenario_file_directory(run: MethodContext) -> str:
    """The folder of the scenario file, as an absolute path."""
    return str(run.file.resolve().parent)


def get_output_directory(run: MethodContext) -> str:
    """The folder for the results of the run, as an absolute path.

    Raises:
        InvalidUse: The run has none.
    """
    if run.output_directory is None:
        raise InvalidUse("the run has no output directory; give it one with `-o`")
    return str(run.output_directory.resolve())
