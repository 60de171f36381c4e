"""Messages of constraints (E0440 to E0444); unsatisfied constraints are reported by runs, from E0442."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.source import Span


class ConstrainedVariable(TemplateMessage):
    """A constraint that contains only variables."""

    CODE = "E0440"
    TEXT = "`{path}` is a variable, and variables cannot be constrained"
    HELP = "constrain a parameter, or wait for the condition: `wait <condition>`"
    OTHERS = (("declared", "the variable is declared here"),)

    path: str
    declared: Span


class NotAParameter(TemplateMessage):
    """`remove_default` of something other than a parameter."""

    CODE = "E0441"
    TEXT = (
        "{declared:if}expected a parameter, found the variable `{path}`",
        "expected the path of a parameter, found `{path}`",
    )
    HELP = "`remove_default` removes the default of a parameter"
    OTHERS = (("declared", "declared here"),)

    path: str
    declared: Span | None


class NotAVariable(TemplateMessage):
    """Something other than the path of a variable."""

    CODE = "E0444"
    TEXT = ("{parameter:if}`{path}` is a parameter, which does not change", "expected the path of a variable")
    LABEL = ("{_is_value:if}this is a value",)
    HELP = ("{parameter:if}declare it as a variable: `var {parameter.text}: ...`",)
    OTHERS = (("parameter", "declared here"),)

    path: str
    parameter: Span | None

    @property
    def _is_value(self) -> bool:
        return self.parameter is None
