"""Deeply nested coroutines on a stack of their own.

Nested coroutines are normally resumed one within the other: each level takes stack frames of Python and C, and
each step of the innermost passes through all levels. `carried` keeps coroutines that await each other by `descend`
in a list instead, and resumes the innermost directly.
"""

from __future__ import annotations

from collections.abc import Awaitable, Coroutine, Generator
from typing import Any, Generic, TypeVar, cast

Result = TypeVar("Result")


class _Descent(Generic[Result]):
    """A nested coroutine, and then its result."""

    __slots__ = ("coroutine", "result")

    def __init__(self, coroutine: Coroutine[Any, Any, Result]) -> None:
        self.coroutine = coroutine
        self.result: Result

    def __await__(self) -> Generator[Any, None, Result]:
        yield self
        return self.result


def descend(coroutine: Coroutine[Any, Any, Result]) -> Awaitable[Result]:
    """Await a coroutine on the stack of the surrounding `carried`."""
    return _Descent(coroutine)


class carried(Generic[Result]):  # noqa: N801 - used like a function, but awaitable
    """Awaitable that runs a coroutine and those nested by `descend`.

    Args:
        coroutine: The outermost coroutine.
    """

    def __init__(self, coroutine: Coroutine[Any, Any, Result]) -> None:
        self._coroutine = coroutine

    def __await__(self) -> Generator[Any, None, Result]:
        innermost: Coroutine[Any, Any, Any] = self._coroutine
        below: list[tuple[Coroutine[Any, Any, Any], _Descent[Any]]] = []  # each waits for the next one
        error: BaseException | None = None
        while True:
            try:
                awaited = innermost.send(None) if error is None else innermost.throw(error)
            except StopIteration as returned:
                if not below:
                    return cast(Result, returned.value)
                innermost, descent = below.pop()
                descent.result, error = returned.value, None
                continue
            except BaseException as raised:
                if not below:
                    raise
                (innermost, _), error = below.pop(), raised
                continue
            error = None
            if type(awaited) is _Descent:
                below.append((innermost, awaited))
                innermost = awaited.coroutine
                continue
            try:
                yield awaited
            except BaseException as thrown:
                error = thrown
