"""Messages of constraints (E0440 to E0444); unsatisfied constraints are reported by runs, from E0442."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.source import Span


def constrained_variable(span: Span, path: str, declared: Span) -> Diagnostic:
    """A constraint that contains only variables."""
    text = f"`{path}` is a variable, and variables cannot be constrained"
    hint = "constrain a parameter, or wait for the condition: `wait <condition>`"
    return error("E0440", span, text, hint, other=declared, remark="the variable is declared here")


def not_a_parameter(span: Span, path: str, declared: Span | None) -> Diagnostic:
    """`remove_default` of something other than a parameter."""
    expected, found = ("a parameter", "the variable ") if declared else ("the path of a parameter", "")
    text = f"expected {expected}, found {found}`{path}`"
    hint = "`remove_default` removes the default of a parameter"
    return error("E0441", span, text, hint, other=declared, remark="declared here")


def not_a_variable(span: Span, path: str, parameter: Span | None) -> Diagnostic:
    """Something other than the path of a variable."""
    if parameter is None:
        return error("E0444", span, "expected the path of a variable", label="this is a value")
    text = f"`{path}` is a parameter, which does not change"
    hint = f"declare it as a variable: `var {parameter.text}: ...`"
    return error("E0444", span, text, hint, other=parameter, remark="declared here")
