"""Runs in child processes of the site."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager


class OwnRuns:
    """Runs that neither a node nor an executor knows, so that the site stops them itself in an emergency."""

    def __init__(self) -> None:
        self._active: dict[object, tuple[str, Callable[[], object]]] = {}

    @contextmanager
    def active(self, name: str, stop: Callable[[], object]) -> Iterator[None]:
        """Note a run while the block lasts.

        Args:
            name: Name of the run, for people.
            stop: Stops it without waiting.
        """
        key = object()
        self._active[key] = name, stop
        try:
            yield
        finally:
            del self._active[key]

    def stop_all(self) -> list[str]:
        """Stop all active runs; returns their names."""
        active = list(self._active.values())
        for _, stop in active:
            stop()
        return [name for name, _ in active]
