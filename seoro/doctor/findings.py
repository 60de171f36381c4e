"""What is found, one line each."""

from __future__ import annotations

from enum import StrEnum

from seoro.lang.frozen import Value


class Health(StrEnum):
    """How something is."""

    OK = "ok"
    WARNING = "warning"  # something does not work that a run may do without
    FAILED = "failed"


class Finding(Value):
    """Something that was looked at.

    Args:
        what: What was looked at, in a word or two.
        health: How it is.
        text: What was found.
        help: What to do about it; empty if there is nothing to do.
    """

    what: str
    health: Health
    text: str
    help: str = ""


def ok(what: str, text: str) -> Finding:
    """Something that is as it should be."""
    return Finding(what, Health.OK, text)


def warning(what: str, text: str, advice: str) -> Finding:
    """Something that some runs do not work without."""
    return Finding(what, Health.WARNING, text, advice)


def failed(what: str, text: str, advice: str) -> Finding:
    """Something that does not work."""
    return Finding(what, Health.FAILED, text, advice)
