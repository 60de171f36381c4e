"""Messages of constraints (E044); those about the values that meet them come from the run, as E0442 and on."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class ConstrainedVariable(Frozen):
    """A constraint of nothing but variables."""

    span: Span
    path: str
    declared: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.path}` is a variable, and variables cannot be constrained"
        hint = "constrain a parameter, or wait for the condition: `wait <condition>`"
        return error("E0440", self.span, text, Label(self.declared, "the variable is declared here"), help=hint)


class NoParameter(Frozen):
    """`remove_default` of something that is no parameter."""

    span: Span
    path: str
    declared: Span | None

    def diagnostic(self) -> Diagnostic:
        """The message."""
        others = (Label(self.declared, "it is declared here"),) if self.declared is not None else ()
        kind = "a variable" if others else "no path to a parameter"
        hint = "only the defaults of parameters can be removed"
        return error("E0441", self.span, f"`{self.path}` is {kind}", *others, help=hint)


class NoVariable(Frozen):
    """Something else where the path of a variable is asked for."""

    span: Span
    path: str
    parameter: Span | None

    def diagnostic(self) -> Diagnostic:
        """The message."""
        if self.parameter is None:
            return error("E0444", self.span, "expected the path of a variable", label="this is a value")
        other = Label(self.parameter, "it is declared here")
        hint = f"declare it as a variable: `var {self.parameter.text}: ...`"
        return error("E0444", self.span, f"`{self.path}` is a parameter, which does not change", other, help=hint)
