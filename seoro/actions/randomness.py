"""Methods of the struct `random` in `osc.helpers`.

All values of the type share one stream of the run, derived from its seed. `seed` restarts the stream, from then on
independent of the seed of the run.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from seoro.errors import UsageError
from seoro.runtime.values.environment import MethodContext


def _stream(run: MethodContext) -> random.Random:
    return run.random("osc.helpers.random")


def seed(run: MethodContext, seed_value: int) -> None:
    """Restart the stream with a seed."""
    _stream(run).seed(seed_value)


def get_float(run: MethodContext, min_val: float, max_val: float) -> float:
    """Return a uniformly distributed number between two bounds.

    Raises:
        UsageError: The bounds are in the wrong order.
    """
    _check(min_val, max_val)
    return _stream(run).uniform(min_val, max_val)


def get_int(run: MethodContext, min_val: int, max_val: int) -> int:
    """Return a uniformly distributed integer between two bounds, inclusive.

    Raises:
        UsageError: The bounds are in the wrong order.
    """
    _check(min_val, max_val)
    return _stream(run).randint(min_val, max_val)


def get_random_string(run: MethodContext, elements_list: Sequence[str]) -> str:
    """Return a random element of a list.

    Raises:
        UsageError: The list is empty.
    """
    if not elements_list:
        raise UsageError("`elements_list` is empty; expected at least one element")
    return _stream(run).choice(elements_list)


def _check(low: float, high: float) -> None:
    if low > high:
        raise UsageError(f"`min_val` ({low:g}) is above `max_val` ({high:g})")
