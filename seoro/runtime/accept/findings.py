"""Findings of the check of a trace: violated rules, and undecided ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

from seoro.lang.source import Span


class Rule(Enum):
    """A rule for traces, with its section of the standard or another source (`docs/reference/trace.md`)."""

    STRUCTURE = "structure", "interface, trace"
    TREE = "tree", "7.6.1.4"
    DIRECT = "direct", "7.6.2.1.1"
    SERIAL = "serial", "7.6.2.1.2"
    ONE_OF = "one_of", "7.6.2.1.3"
    PARALLEL = "parallel", "7.6.2.1.4"
    OUTCOME = "outcome", "runtime, outcomes"
    CONSTRAINT = "constraint", "7.6.2.3"
    VALUE = "value", "7.6.2.2"
    VARIABLE = "variable", "7.3.6.1.2"
    ACTION = "action", "osc.helpers"
    DURATION = "duration", "7.6.2.4"
    EVENT = "event", "7.6.2.5.1"
    EMIT = "emit", "7.6.2.5.2"
    WAIT = "wait", "7.6.2.5.3"
    UNTIL = "until", "7.6.2.5.4"
    ON = "on", "7.6.2.5.5"
    SAMPLE = "sample", "7.3.6.1.2"
    MODIFIER = "modifier", "7.3.12"
    OVERRIDE = "override", "7.3.12.1.1"

    def __init__(self, title: str, section: str) -> None:
        self.title = title
        self.section = section


@dataclass(frozen=True, slots=True)
class Violation:
    """A violation of a rule.

    Args:
        rule: The rule.
        message: Description in a sentence.
        span: Text of the scenario, or None.
        records: `seq` of the records that violate it.
    """

    rule: Rule
    message: str
    span: Span | None
    records: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Unchecked:
    """An undecided rule.

    Args:
        rule: The rule.
        reason: Reason why it is undecided.
        span: Text of the scenario, or None.
        count: Number of cases.
    """

    rule: Rule
    reason: str
    span: Span | None
    count: int


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Result of the check of a trace.

    Args:
        violations: Violations, in the order of their records.
        unchecked: Undecided rules.
        records: Number of records.
    """

    violations: tuple[Violation, ...]
    unchecked: tuple[Unchecked, ...]
    records: int

    @property
    def accepted(self) -> bool:
        """Whether no rule is violated."""
        return not self.violations

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        violations = (
            _plain(each, "message", each.message) | {"records": list(each.records)} for each in self.violations
        )
        unchecked = (_plain(each, "reason", each.reason) | {"count": each.count} for each in self.unchecked)
        return {
            "accepted": self.accepted,
            "records": self.records,
            "violations": list(violations),
            "not_checked": list(unchecked),
        }


def _plain(found: Violation | Unchecked, name: str, text: str) -> dict[str, Any]:
    """Return the rule, a text and the place of a finding for JSON."""
    source = str(found.span) if found.span is not None else ""
    return {"rule": found.rule.title, "section": found.rule.section, name: text, "source": source}


class Undecided(Exception):
    """The trace lacks the data for a rule; the message names it."""


@dataclass(eq=False)
class Findings:
    """Collects violations and undecided rules."""

    _violations: dict[Violation, None] = field(default_factory=dict)
    _unchecked: Counter[tuple[Rule, str, Span | None]] = field(default_factory=Counter)

    def violate(self, rule: Rule, message: str, span: Span | None, *records: int) -> None:
        """Report a violation.

        Args:
            rule: The rule.
            message: Description.
            span: Place in the scenario.
            records: Indices of the records that violate it, from 0.
        """
        self._violations[Violation(rule, message, span, tuple(sorted(set(records))))] = None

    def skip(self, rule: Rule, reason: object, span: Span | None) -> None:
        """Report an undecided rule."""
        self._unchecked[rule, str(reason), span] += 1

    @contextmanager
    def undecided(self, rule: Rule, span: Span | None, also: type[Exception] = Undecided) -> Iterator[None]:
        """Report an undecided rule if the block raises `Undecided` or another exception."""
        try:
            yield
        except (Undecided, also) as reason:
            self.skip(rule, reason, span)

    def acceptance(self, numbers: Sequence[int]) -> Acceptance:
        """Return the result.

        Args:
            numbers: The `seq` of the records in order; rules use indices from 0 instead.
        """
        ordered = sorted(self._violations, key=lambda violation: violation.records or (-1,))
        violations = (
            replace(each, records=tuple(numbers[place] for place in each.records if place < len(numbers)))
            for each in ordered
        )
        unchecked = (Unchecked(*key, count) for key, count in self._unchecked.items())
        return Acceptance(tuple(violations), tuple(unchecked), len(numbers))
