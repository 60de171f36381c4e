"""What checking a trace finds: rules that are broken, and what could not be decided."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

from seoro.lang.source import Span


class Rule(Enum):
    """A rule that a trace keeps, and the section of the standard, or what else says so (`docs/accept.md`)."""

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
    """A rule that is broken.

    Args:
        rule: The rule.
        message: What is wrong, in a sentence.
        span: Which text of the scenario is concerned, if any is.
        records: The `seq` of the records that break it.
    """

    rule: Rule
    message: str
    span: Span | None
    records: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Unchecked:
    """What could not be decided.

    Args:
        rule: The rule.
        reason: Why.
        span: Which text of the scenario it is about, if any.
        count: How often.
    """

    rule: Rule
    reason: str
    span: Span | None
    count: int


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Whether a trace is accepted.

    Args:
        violations: In the order of the records that break rules.
        unchecked: What could not be decided.
        records: How many records there are.
    """

    violations: tuple[Violation, ...]
    unchecked: tuple[Unchecked, ...]
    records: int

    @property
    def accepted(self) -> bool:
        """Whether no rule is broken."""
        return not self.violations

    def plain(self) -> dict[str, Any]:
        """The same, as JSON knows it."""
        return {
            "accepted": self.accepted,
            "records": self.records,
            "violations": [
                {
                    "rule": violation.rule.title,
                    "section": violation.rule.section,
                    "message": violation.message,
                    "source": str(violation.span) if violation.span is not None else "",
                    "records": list(violation.records),
                }
                for violation in self.violations
            ],
            "not_checked": [
                {
                    "rule": unchecked.rule.title,
                    "section": unchecked.rule.section,
                    "reason": unchecked.reason,
                    "source": str(unchecked.span) if unchecked.span is not None else "",
                    "count": unchecked.count,
                }
                for unchecked in self.unchecked
            ],
        }


class Undecided(Exception):
    """What a rule asks for cannot be told from the trace; the message says why."""


@dataclass(eq=False)
class Findings:
    """Collects what is found."""

    _violations: dict[Violation, None] = field(default_factory=dict)
    _unchecked: Counter[tuple[Rule, str, Span | None]] = field(default_factory=Counter)

    def violate(self, rule: Rule, message: str, span: Span | None, *records: int) -> None:
        """A rule is broken.

        Args:
            rule: The rule.
            message: What is wrong.
            span: Where in the scenario.
            records: The places of the records that break it, from 0.
        """
        self._violations[Violation(rule, message, span, tuple(sorted(set(records))))] = None

    def skip(self, rule: Rule, reason: object, span: Span | None) -> None:
        """A rule cannot be decided."""
        self._unchecked[rule, str(reason), span] += 1

    def acceptance(self, numbers: Sequence[int]) -> Acceptance:
        """All of it.

        Args:
            numbers: The `seq` of the records in their order; rules count records from 0, whatever their `seq` is.
        """
        ordered = sorted(self._violations, key=lambda violation: violation.records or (-1,))
        violations = (
            replace(each, records=tuple(numbers[place] for place in each.records if place < len(numbers)))
            for each in ordered
        )
        unchecked = (Unchecked(*key, count) for key, count in self._unchecked.items())
        return Acceptance(tuple(violations), tuple(unchecked), len(numbers))
