"""Messages of methods and of operators that look like them (E0340 to E0359)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class MissingOnly(Frozen):
    """A method that overrides another without saying so (7.3.7.2)."""

    span: Span
    name: str
    first: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "which is declared here")
        hint = "say `is only ...` to override it"
        return error("E0340", self.span, f"`{self.name}` overrides another method", before, help=hint)


class OtherSignature(Frozen):
    """A method with another signature than the one that it overrides (7.3.7.2)."""

    span: Span
    name: str
    difference: str
    first: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "the overridden one is here")
        text = f"`{self.name}` differs from the method that it overrides in {self.difference}"
        return error("E0341", self.span, text, before)


class UnknownMethod(Frozen):
    """A call of a method that there is not."""

    span: Span
    owner: str
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        if not hint and self.candidates:
            hint = f"it has {listing(self.candidates)}"
        return error("E0342", self.span, f"{self.owner} has no method `{self.name}`", help=hint)


class NoResult(Frozen):
    """A method without a result in an expression (7.4.2.1)."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "only `call` can invoke it; a method with a result is declared as `def ... -> <type> is ...`"
        return error("E0343", self.span, f"method `{self.name}` has no result", help=hint)


class WrongOperands(Frozen):
    """An operator like `size()` with other arguments than it takes."""

    span: Span
    name: str
    needed: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0344", self.span, f"`{self.name}` takes {self.needed}")


class NoIt(Frozen):
    """`it` where it stands for nothing."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = (
            "it is the instance of a type in its members, and the member of a list in `filter(...)` and its like"
        )
        return error("E0345", self.span, "`it` stands for nothing here", help=hint)


class ImpossibleCast(Frozen):
    """`as` between types of which no value of one is ever of the other (7.4.2.6)."""

    span: Span
    found: str
    target: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0346", self.span, f"{self.found} can never be converted to {self.target}")


class NoPath(Frozen):
    """An external method whose name is no dotted path to a function."""

    span: Span
    path: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "write the path of a Python function, such as `external package.module.function()`"
        return error("E0347", self.span, f"`{self.path}` names no function of a module", help=hint)
