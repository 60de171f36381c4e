"""Coroutines within coroutines, to any depth, on a stack of their own.

Coroutines that await each other are resumed one within the other: each level takes frames of Python, whose number
is limited, and of C, and every step of the innermost goes through all of them. `carried` keeps the coroutines that
await each other by `descend` in a list instead, and resumes the innermost only.
"""

from __future__ import annotations

from collections.abc import Awaitable, Coroutine, Generator
from typing import Any, Generic, TypeVar, cast

Result = TypeVar("Result")


class _Descent(Generic[Result]):
    """A coroutine that is to be carried out, and then what it returned."""

    __slots__ = ("coroutine", "result")

    def __init__(self, coroutine: Coroutine[Any, Any, Result]) -> None:
        self.coroutine = coroutine
        self.result: Result

    def __await__(self) -> Generator[Any, None, Result]:
        yield self
        return self.result


def descend(coroutine: Coroutine[Any, Any, Result]) -> Awaitable[Result]:
    """Await a coroutine on the stack of `carried`, within which this is."""
    return _Descent(coroutine)


class carried(Generic[Result]):  # noqa: N801 - it is used like a function, and has to be awaitable
    """Awaitable that carries a coroutine out, and those to which it descends.

    Args:
        coroutine: The outermost.
    """

    def __init__(self, coroutine: Coroutine[Any, Any, Result]) -> None:
        self._coroutine = coroutine

    def __await__(self) -> Generator[Any, None, Result]:
        stack: list[Coroutine[Any, Any, Any]] = [self._coroutine]
        descents: list[_Descent[Any]] = []
        error: BaseException | None = None
        while True:
            try:
                awaited = stack[-1].send(None) if error is None else stack[-1].throw(error)
            except StopIteration as returned:
                del stack[-1]
                if not descents:
                    return cast(Result, returned.value)
                descents.pop().result = returned.value
                error = None
                continue
            except BaseException as raised:
                del stack[-1]
                if not descents:
                    raise
                descents.pop()
                error = raised
                continue
            error = None
            if type(awaited) is _Descent:
                descents.append(awaited)
                stack.append(awaited.coroutine)
                continue
            try:
                yield awaited
            except BaseException as thrown:
                error = thrown
