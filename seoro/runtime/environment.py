"""What names in an expression stand for while it is evaluated, and the error of those that have no value."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import TypeAlias

from seoro.lang import frozen
from seoro.lang.plan import Expression
from seoro.lang.source import Span
from seoro.runtime.method_context import MethodContext
from seoro.runtime.values import HasFields, Value


class EvaluationError(Exception):
    """An expression has no value, such as a division of integers by zero."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


class NotInvoked(EvaluationError):
    """Nothing has been invoked yet under a label that the expression names."""


class NoChoice(EvaluationError):
    """There are no values that meet all constraints.

    Args:
        message: What is wrong.
        code: `E0442` if constraints clash, `E0443` if no value was found.
        places: The places in the text that have to do with it, each with what to say of it; at least one.
        help: What to do.
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
    """What external methods have returned while values are chosen.

    Expressions are then evaluated again and again. So that what a method draws at a place stays, it is called
    there once for the same arguments.

    Args:
        results: By place and arguments.
        place: The calls that are being evaluated, each with the instance in whose scope it stands.
    """

    results: dict[Hashable, Value] = field(default_factory=dict)
    place: tuple[object, ...] = ()

    def within(self, span: Span, instance: object) -> Calls:
        """The same, within a call."""
        return Calls(self.results, (*self.place, span, instance))


@dataclass(eq=False)
class Reads:
    """What an expression has read while it was evaluated.

    Args:
        fields: What holds them, by its identity and the name of the field.
        is_external: Whether an external method was called, which may have read anything.
    """

    fields: dict[tuple[int, str], HasFields] = field(default_factory=dict)
    is_external: bool = False


class Seed:
    """What something is drawn from, the same on any machine; computed when it is, since mostly nothing is drawn.

    Args:
        base: The seed of the run, or a seed for something around.
        purpose: What this one is for; without, it is the base.
    """

    __slots__ = ("_base", "_purpose")

    def __init__(self, base: int | Seed, purpose: str | None = None) -> None:
        self._base = base
        self._purpose = purpose

    @property
    def value(self) -> int:
        """The number."""
        base = self._base if isinstance(self._base, int) else self._base.value
        if self._purpose is None:
            return base
        return int.from_bytes(sha256(f"{base}/{self._purpose}".encode()).digest()[:8], "big")


class Deferred(frozen.Frozen):
    """What a name is bound to whose value may not be there yet.

    Args:
        expression: What it stands for.
        environment: The scope of that.
    """

    expression: Expression
    environment: Environment


_NO_SEED = Seed(0)


@dataclass(eq=False, slots=True)
class Environment:
    """What names in an expression stand for; never changed, but not frozen, since each behavior gets several.

    Args:
        instance: Whose fields they are.
        bindings: `actor`, what an `as` clause binds, the parameters of a method, and `it` of lists.
        path: Where a value that is constructed will be held; names actors.
        scenario: The scenario around, whose fields hold the global parameters too; None if it is the instance.
        depth: How many methods have been called to get here.
        seed: What is drawn for values that are constructed is drawn from it.
        run: The run, for external methods that ask for it.
        calls: What external methods have returned, while values are chosen; None otherwise.
        reads: Keeps what is read; None if nobody wants to know.
    """

    instance: HasFields
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
        """The scenario around."""
        return self.scenario or self.instance

    def reading(self, reads: Reads) -> Environment:
        """The same, which keeps what is read; made by hand, since conditions are evaluated often."""
        return Environment(
            self.instance,
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
