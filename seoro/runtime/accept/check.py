"""Check of a trace: reads it, matches it with the plan, and applies all rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.lang.plan import Plan
from seoro.runtime.accept.channels import Channels, Received
from seoro.runtime.accept.compositions import was_overridden
from seoro.runtime.accept.constraining import ValueChecker, VariableChecker
from seoro.runtime.accept.emitting import EventChecker
from seoro.runtime.accept.findings import Acceptance, Findings, Rule
from seoro.runtime.accept.fixed_actions import ActionChecker
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Matched
from seoro.runtime.accept.history import History
from seoro.runtime.accept.modifying import ModifierChecker, OverrideChecker
from seoro.runtime.accept.moments import Moments
from seoro.runtime.accept.pasts import Pasts
from seoro.runtime.accept.reacting import ReactionChecker
from seoro.runtime.accept.structure import read_history
from seoro.runtime.accept.tree import Tree
from seoro.runtime.accept.waiting import WaitChecker
from seoro.runtime.accept.world import World

# End of a run, by the end of its root behavior; any run may also end as an error, or be stopped.
_ENDS = {SUCCEEDED: "passed", FAILED: "failed", CANCELLED: "failed"}


def check_trace(plan: Plan, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Check whether a scenario accepts a trace.

    Args:
        plan: The scenario, lowered with the same entry and the same overrides.
        records: Records of the trace, from observers or from JSON.
    """
    findings = Findings()
    history = read_history(records, findings)
    if history is not None:
        _check(plan, history, findings)
    return findings.acceptance([_number(place, record) for place, record in enumerate(records)])


def _check(plan: Plan, history: History, findings: Findings) -> None:
    world = World(plan, history, findings)
    matched = Tree(history, world, findings).match()
    if matched is None:
        return
    channels = Channels(plan, history, world)
    moments = Moments(history, world, channels, Received(plan))
    emitting = EventChecker(history, world, findings, channels, moments)
    pasts = Pasts(history, matched, channels, emitting.emitted(matched))
    WaitChecker(history, world, findings, moments, pasts).check(matched)
    ReactionChecker(history, world, findings, moments, pasts).check(matched)
    emitting.check(matched)
    ModifierChecker(history, world, findings).check(matched)
    OverrideChecker(history, world, findings).check(matched)
    ValueChecker(history, world, findings).check(matched)
    VariableChecker(history, world, findings).check()
    ActionChecker(history, world, findings).check(matched)
    _check_verdict(plan, history, matched, findings)


def _check_verdict(plan: Plan, history: History, matched: Matched, findings: Findings) -> None:
    """Check that the run ends as its root behavior."""
    root, status = history.root, history.end["status"]
    span = plan.scenarios[plan.entry].span
    if history.is_exact and root.start.t != 0:
        findings.violate(Rule.DIRECT, f"the run begins at {root.start.t:g} s", span, 0, root.start.seq)
    if history.end["t"] != root.end.t:
        message = f"the run ends at {history.end['t']:g} s, but its scenario at {root.end.t:g} s"
        findings.violate(Rule.DIRECT, message, span, root.end.seq, history.end["seq"])
    if status == "failed" and root.status == CANCELLED and not _waits(history):
        message = "the run failed with a cancelled scenario, but no behavior was waiting"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, history.end["seq"])
    is_overridden = status == "passed" and was_overridden([root], matched.overridden)
    if status not in ("error", "cancelled", _ENDS.get(root.status)) and not is_overridden:
        message = f"the run {status}, but its scenario {root.status}"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, history.end["seq"])


def _waits(history: History) -> bool:
    """Whether a behavior was waiting at the end of the run, which was then stuck."""
    return any(child.status == CANCELLED and child.end.t == history.root.end.t for child in history.root.children)


def _number(place: int, record: Mapping[str, Any]) -> int:
    """Return the `seq` of a record; if missing, its index."""
    recorded = record.get("seq")
    return recorded if isinstance(recorded, int) else place
