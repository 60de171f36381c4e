"""Lists with unknown members, and results of their methods."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.lang.plan import Bulk, Index
from seoro.runtime.choose.forms import NotSymbolic, Symbolic, any_of, as_term, count_of, listed
from seoro.runtime.values.environment import EvaluationError


def member(items: tuple[Symbolic, ...], position: Symbolic, expression: Index) -> Symbolic:
    """Return a member of a list.

    Raises:
        NotSymbolic: The position is unknown.
        EvaluationError: It is outside the list.
    """
    if not isinstance(position, int):
        raise NotSymbolic
    if not 0 <= position < len(items):
        raise EvaluationError(f"index {position} is outside of a list of {len(items)}", expression.span)
    return items[position]


def gathered(operator: Bulk, items: tuple[Symbolic, ...], results: Sequence[Symbolic]) -> Symbolic:
    """Return the result of a list method from the results for its members.

    Raises:
        NotSymbolic: It depends on unknown results.
    """
    match operator:
        case Bulk.MAP:
            return listed(tuple(results))
        case Bulk.HAS:
            return any_of([as_term(result) for result in results])
        case Bulk.COUNT:
            return count_of([as_term(result) for result in results])
        case Bulk.FILTER if all(isinstance(result, bool) for result in results):
            return listed(tuple(item for item, result in zip(items, results, strict=True) if result))
        case Bulk.FIRST_INDEX if all(isinstance(result, bool) for result in results):
            return results.index(True) if True in results else -1
        case _:
            raise NotSymbolic
