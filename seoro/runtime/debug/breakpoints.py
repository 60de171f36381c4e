"""Breakpoints: lines of scenario files at which a run pauses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from seoro.lang.frozen import Value
from seoro.lang.plan import Expression
from seoro.lang.source import SourceFile, Span
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.values.environment import Environment, EvaluationError


class Breakpoint(Value):
    """A line at which a run pauses before a behavior starts.

    Args:
        line: The line, from 1.
        condition: Boolean expression that must hold; None for always.
    """

    line: int
    condition: Expression | None = None


class Breakpoints:
    """The breakpoints of a run, by file and line.

    Attributes:
        on_error: Called with the text of a condition without a value, at which the run pauses too.
    """

    def __init__(self) -> None:
        self._of_files: dict[Path, Mapping[int, Breakpoint]] = {}
        self._paths: dict[SourceFile, Path | None] = {}  # without links
        self.on_error: Callable[[str], object] = lambda message: None

    def replace(self, file: Path, found: Mapping[int, Breakpoint]) -> None:
        """Replace all breakpoints of a file.

        Args:
            file: The file, as an absolute path without links.
            found: Breakpoints by line.
        """
        self._of_files[file] = found

    def path_of(self, span: Span) -> Path | None:
        """Return the absolute path of the file of a span, without links; None for other texts."""
        file = span.file
        if file not in self._paths:
            self._paths[file] = file.path.resolve() if file.path is not None else None
        return self._paths[file]

    def is_met(self, span: Span, environment: Callable[[], Environment]) -> bool:
        """Whether a behavior that starts at a span meets a breakpoint.

        Args:
            span: Span of the behavior.
            environment: Returns the environment of its expressions.
        """
        path = self.path_of(span) if self._of_files else None
        found = self._of_files.get(path, {}).get(span.line) if path is not None else None
        if found is None:
            return False
        if found.condition is None:
            return True
        try:
            return bool(evaluate(found.condition, environment()))
        except EvaluationError as error:
            self.on_error(f"the condition of the breakpoint in line {found.line} has no value: {error}")
            return True
