"""Whether a trace is accepted by a scenario (7.6): a check that is independent of what made the trace.

    acceptance = check_trace(plan, records)
    assert acceptance.accepted, acceptance.violations

Of the runtime it shares the values and the evaluation of expressions, and nothing that carries a scenario out.
`docs/accept.md` lists the rules, and what a trace cannot decide.
"""

from __future__ import annotations

from seoro.runtime.accept.check import check_trace
from seoro.runtime.accept.findings import Acceptance, Rule, Unchecked, Violation

__all__ = ["Acceptance", "Rule", "Unchecked", "Violation", "check_trace"]
