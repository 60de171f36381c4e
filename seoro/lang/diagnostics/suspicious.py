"""Messages about suspicious code (E07): warnings about valid text."""

from __future__ import annotations

from typing import Final

from seoro.lang.diagnostic import Diagnostic, Label, warning
from seoro.lang.frozen import replaced
from seoro.lang.source import Span

UNUSED_PARAMETER: Final = "E0702"
UNUSED_EVENT: Final = "E0703"
UNUSED_IMPORT: Final = "E0704"
UNREACHABLE: Final = "E0705"
UNUSED_SUPPRESSION: Final = "E0709"
UNUSED_LABEL: Final = "E0711"
OPTIONAL: Final = frozenset({UNUSED_LABEL})
"""Codes that are reported only where they are asked for: labels also name behaviors in traces."""


def never_emitted(span: Span, name: str) -> Diagnostic:
    """An event that a behavior waits for, and that no directive emits."""
    hint = f"add `emit {name}`; if a program emits the event, write `# noqa: E0701` at the end of the line"
    return warning("E0701", span, f"nothing emits the event `{name}`", hint)


def unused_parameter(span: Span, name: str, kind: str) -> Diagnostic:
    """A parameter or variable of a scenario without a use."""
    return warning(UNUSED_PARAMETER, span, f"unused {kind} `{name}`", "remove it, or use it")


def unused_event(span: Span, name: str) -> Diagnostic:
    """An event of a scenario that is neither emitted nor awaited."""
    return warning(UNUSED_EVENT, span, f"unused event `{name}`", "remove it, or emit it")


def unused_import(span: Span, name: str) -> Diagnostic:
    """An import whose names do not occur in the file."""
    return warning(UNUSED_IMPORT, span, f"unused import `{name}`", "remove it")


def unreachable(span: Span, emitted: str) -> Diagnostic:
    """A member of `serial` behind the end of its scenario."""
    hint = f"`emit {emitted}` ends the scenario; move it to the end, or remove what follows"
    return warning(UNREACHABLE, span, f"unreachable behavior after `emit {emitted}`", hint)


def constant_condition(span: Span) -> Diagnostic:
    """A condition of literals only."""
    return warning("E0706", span, "constant condition", "compare a parameter or a variable")


def impossible_timeout(span: Span, limit: float, needed: float) -> Diagnostic:
    """A timeout below the sum of the fixed times within it; both in seconds."""
    hint = f"expected more than {needed:g} s: the sum of `wait elapsed(...)` within it"
    return warning("E0707", span, f"the timeout of {limit:g} s always expires", hint)


def impossible_duration(span: Span, limit: float, needed: float) -> Diagnostic:
    """A duration below the sum of the fixed times within it; both in seconds."""
    hint = f"expected {needed:g} s or more: the sum of `wait elapsed(...)` within it"
    return warning("E0707", span, f"the duration of {limit:g} s cannot be met", hint)


def unused_label(span: Span, name: str) -> Diagnostic:
    """A label that no expression, event or argument names."""
    return warning(
        UNUSED_LABEL, span, f"unused label `{name}`", "remove it, or keep it as a name in traces and reports"
    )


def shadowed(span: Span, name: str, hidden: Span) -> Diagnostic:
    """A name that hides a global parameter, or a parameter of a method that hides a field."""
    found = warning("E0710", span, f"`{name}` hides another declaration", "rename one of them")
    return replaced(found, secondary=(Label(hidden, "hidden here"),))


def unknown_suppression(span: Span, code: str, hint: str) -> Diagnostic:
    """An unknown code in a `noqa` comment."""
    return warning("E0708", span, f"unknown code `{code}` in `noqa`", hint)


def unused_suppression(span: Span, code: str) -> Diagnostic:
    """A `noqa` comment, or a code in it, that suppresses nothing; `code` is empty for all codes."""
    what = f"`{code}` in `noqa`" if code else "`noqa`"
    return warning(UNUSED_SUPPRESSION, span, f"unused {what}: the line has no such warning", "remove it")
