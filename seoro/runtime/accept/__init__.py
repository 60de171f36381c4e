"""Check whether a scenario accepts a trace (7.6), independent of the program that made the trace.

    acceptance = check_trace(plan, records)
    assert acceptance.accepted, acceptance.violations

It shares values and the evaluation of expressions with the runtime, but no execution of scenarios.
`docs/reference/trace.md` lists the rules, and what a trace cannot decide.
"""

from __future__ import annotations

from seoro.runtime.accept.check import check_trace
from seoro.runtime.accept.findings import Acceptance, Rule, Unchecked, Violation

__all__ = ["Acceptance", "Rule", "Unchecked", "Violation", "check_trace"]
