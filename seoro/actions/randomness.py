"""The methods of the struct `random` in `osc.helpers`.

All values of the type draw from one stream of the run, which comes from its seed; `seed` starts the stream anew,
from then on independent of the seed of the run.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from seoro.errors import InvalidUse
from seoro.runtime.method_context import MethodContext


def _stream(run: MethodContext) -> random.Random:
    return run.random("osc.helpers.random")


def seed(run: MethodContext, seed_value: int) -> None:
    """Start the stream anew, with a seed of the scenario's own."""
    _stream(run).seed(seed_value)


def get_float(run: MethodContext, min_val: float, max_val: float) -> float:
    """A number between two bounds, all equally likely.

    Raises:
        InvalidUse: The bounds are in the wrong order.
    """
    _check(min_val, max_val)
    return _stream(run).uniform(min_val, max_val)


def get_int(run: MethodContext, min_val: int, max_val: int) -> int:
    """A whole number from one bound to the other, both included, all equally likely.

    Raises:
        InvalidUse: The bounds are in the wrong order.
    """
    _check(min_val, max_val)
    return _stream(run).randint(min_val, max_val)


def get_random_string(run: MethodContext, elements_list: Sequence[str]) -> str:
    """One of the elements of a list, all equally likely.

    Raises:
        InvalidUse: The list is empty.
    """
    if not elements_list:
        raise InvalidUse("`elements_list` is empty")
    return _stream(run).choice(elements_list)


def _check(low: float, high: float) -> None:
    if low > high:
        raise InvalidUse(f"`min_val` ({low:g}) is above `max_val` ({high:g})")
