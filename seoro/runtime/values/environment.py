"""Environments of expressions, and the error of expressions without a value.

External methods take no time, and most need only their arguments. A Python function whose first parameter is
annotated with `MethodContext` receives the run first: for random numbers from the run's seed, and for paths of the
run's files.
"""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable, Hashable, Mapping
from dataclasses import field, replace
from hashlib import sha256
from pathlib import Path
from typing import TypeAlias

from seoro.deferred import dataclass
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.lang import frozen
from seoro.lang.plan import Expression, Plan
from seoro.lang.source import Span
from seoro.runtime.values.values import HasFields, Value


class MethodContext:
    """The run as seen by external methods.

    Args:
        seed: Seed of all random numbers.
        file: The scenario file.
        output_directory: Output folder of the run, or None.
        locate: Maps absolute paths of files.
    """

    def __init__(
        self, seed: int, file: Path, output_directory: Path | None = None, locate: Locate = unchanged_path
    ) -> None:
        self.seed = seed
        self._locate = locate
        self.file = file
        self.output_directory = output_directory
        self._streams: dict[str, random.Random] = {}

    def resolve_path(self, name: str) -> Path:
        """Resolve a path in the scenario: relative to the scenario file, or absolute."""
        return self._locate(self.file.parent / name)

    def random(self, purpose: str) -> random.Random:
        """Return the stream of random numbers for a purpose; it lasts as long as the run.

        On the clocks `virtual` and `sim`, methods are called in the same order in each run with a seed, and draw
        the same numbers.
        """
        if purpose not in self._streams:
            # With a prefix, so that it differs from all streams of behaviors.
            self._streams[purpose] = random.Random(f"{self.seed}/method/{purpose}")  # noqa: S311 - reproducible
        return self._streams[purpose]


class EvaluationError(Exception):
    """An expression has no value, such as a division of integers by zero."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


class NotInvoked(EvaluationError):
    """A label in the expression has not been invoked yet."""


class NoSolution(EvaluationError):
    """No values meet all constraints.

    Args:
        message: Description of the conflict.
        code: `E0442` for a conflict, `E0443` if no value was found.
        places: Involved places in the text, each with a note; at least one.
        help: Possible fix.
    """

    def __init__(
        self,
        message: str,
        code: str,
        places: tuple[tuple[Span, str], ...],
        help: str = "",  # noqa: A002
    ) -> None:
        super().__init__(message, places[0][0])
        self.code = code
        self.places = places
        self.help = help


class Calls(frozen.Value):
    """Results of external methods while values are chosen.

    Expressions are then evaluated repeatedly. Each call is made once per place and arguments, so that random
    results stay the same.

    Args:
        results: Results by place and arguments.
        place: Nested calls being evaluated, each with the instance of its scope.
    """

    results: dict[Hashable, Value] = field(default_factory=dict)
    place: tuple[object, ...] = ()

    def within(self, span: Span, instance: object) -> Calls:
        """Return the calls within a nested call."""
        return Calls(self.results, (*self.place, span, instance))


@dataclass(eq=False)
class Reads:
    """Fields that an expression has read while it was evaluated.

    Args:
        fields: Their holders, by identity of the holder and name of the field.
        is_external: Whether an external method was called, which may read anything.
    """

    fields: dict[tuple[int, str], HasFields] = field(default_factory=dict)
    is_external: bool = False


class Seed:
    """Seed for random draws, the same on any machine; computed on demand, since mostly nothing is drawn.

    Args:
        base: Seed of the run, or a surrounding seed.
        purpose: Purpose of the seed; without one, it equals the base.
    """

    __slots__ = ("_base", "_purpose")

    def __init__(self, base: int | Seed, purpose: str | None = None) -> None:
        self._base = base
        self._purpose = purpose

    @property
    def value(self) -> int:
        """The seed as an integer."""
        base = self._base if isinstance(self._base, int) else self._base.value
        if self._purpose is None:
            return base
        return int.from_bytes(sha256(f"{base}/{self._purpose}".encode()).digest()[:8], "big")


class Deferred(frozen.Frozen):
    """Binding whose value may not exist yet.

    Args:
        expression: The bound expression.
        environment: Its environment.
    """

    expression: Expression
    environment: Environment


_NO_SEED = Seed(0)


@dataclasses.dataclass(eq=False, slots=True)
class Environment:
    """Environment of an expression; never changed, but not frozen, since each behavior creates several.

    Args:
        instance: Instance whose fields are visible.
        plan: The plan, with the methods and the structures of all types.
        bindings: `actor`, names of `as` clauses, parameters of a method, and `it` of lists.
        path: Path of a constructed value; names actors.
        scenario: Surrounding scenario, whose fields include global parameters; None if it is the instance.
        depth: Depth of nested method calls.
        seed: Seed for constructed values.
        run: The run, for external methods that need it.
        calls: Results of external methods while values are chosen; otherwise None.
        reads: Collects the fields that are read; None to collect nothing.
    """

    instance: HasFields
    plan: Plan
    bindings: Mapping[str, Value | HasFields] = field(default_factory=dict)
    path: str = ""
    scenario: HasFields | None = None
    depth: int = 0
    seed: Seed = _NO_SEED
    run: MethodContext | None = None
    calls: Calls | None = None
    reads: Reads | None = None

    @property
    def outermost(self) -> HasFields:
        """Surrounding scenario."""
        return self.scenario or self.instance

    def bind(self, **bindings: Value | HasFields) -> Environment:
        """Return an environment with further bindings."""
        return replace(self, bindings={**self.bindings, **bindings})

    def reading(self, reads: Reads) -> Environment:
        """Return an environment that collects reads; copied by hand, since conditions are evaluated often."""
        return Environment(
            self.instance,
            self.plan,
            self.bindings,
            self.path,
            self.scenario,
            self.depth,
            self.seed,
            self.run,
            self.calls,
            reads,
        )


Evaluate: TypeAlias = Callable[[Expression, Environment], Value]
