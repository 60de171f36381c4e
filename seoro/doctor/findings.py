"""Findings: results of checks, one line each."""

from __future__ import annotations

from enum import StrEnum

from seoro.lang.frozen import Value


class Health(StrEnum):
    """Result of a check."""

    OK = "ok"
    WARNING = "warning"  # some runs will not work
    FAILED = "failed"


class Finding(Value):
    """Result of a check, with a description.

    Args:
        what: Checked item, in a word or two.
        health: Result of the check.
        text: Description of the result.
        help: Suggestion for a fix; may be empty.
    """

    what: str
    health: Health
    text: str
    help: str = ""


def ok(what: str, text: str) -> Finding:
    """Make a finding of a passed check."""
    return Finding(what, Health.OK, text)


def warning(what: str, text: str, advice: str) -> Finding:
    """Make a finding that affects some runs."""
    return Finding(what, Health.WARNING, text, advice)


def failed(what: str, text: str, advice: str) -> Finding:
    """Make a finding of a failed check."""
    return Finding(what, Health.FAILED, text, advice)
