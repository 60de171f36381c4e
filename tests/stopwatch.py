"""Times of other processes that a busy machine delays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

ATTEMPTS = 5


def attempts(times: Sequence[float], limit: float) -> Iterator[None]:
    """Yield for each attempt, until one has taken less than a limit.

    Args:
        times: Times of the attempts so far [s]; each attempt appends one.
        limit: Time that an attempt takes at most on an idle machine [s].
    """
    for _ in range(ATTEMPTS):
        yield
        if min(times) < limit:
            return
