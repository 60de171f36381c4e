"""Checking a trace: reading it, matching it with the plan, and all rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.lang.plan import Plan
from seoro.runtime.accept.channels import Channels
from seoro.runtime.accept.compositions import was_overridden
from seoro.runtime.accept.constraining import Constraining
from seoro.runtime.accept.emitting import Emitting
from seoro.runtime.accept.findings import Acceptance, Findings, Rule
from seoro.runtime.accept.fixed_actions import FixedActions
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Matched
from seoro.runtime.accept.hearing import Hearing
from seoro.runtime.accept.history import History
from seoro.runtime.accept.modifying import Modifying
from seoro.runtime.accept.moments import Moments
from seoro.runtime.accept.overriding import Overriding
from seoro.runtime.accept.pasts import Pasts
from seoro.runtime.accept.reacting import Reacting
from seoro.runtime.accept.structure import read_history
from seoro.runtime.accept.tree import Tree
from seoro.runtime.accept.variables import Variables
from seoro.runtime.accept.waiting import Waiting
from seoro.runtime.accept.world import World

# How a run ends, by how the behavior that is all of it does; any run may end as an error, or by being stopped.
_ENDS = {SUCCEEDED: "passed", FAILED: "failed", CANCELLED: "failed"}


def check_trace(plan: Plan, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Whether a trace is accepted by a scenario.

    Args:
        plan: The scenario that was run, lowered with the same entry and the same overrides.
        records: The records of the trace, as observers see them or as JSON has them.
    """
    findings = Findings()
    history = read_history(records, findings)
    if history is not None:
        _check(plan, history, findings)
    return findings.acceptance([_number(place, record) for place, record in enumerate(records)])


def _check(plan: Plan, history: History, findings: Findings) -> None:
    world = World(plan, history, findings)
    matched = Tree(plan, history, world, findings).match()
    if matched is None:
        return
    channels = Channels(plan, history, world)
    moments = Moments(history, world, channels, Hearing(plan))
    emitting = Emitting(history, world, channels, moments, findings)
    pasts = Pasts(history, matched, channels, emitting.emitted(matched))
    Waiting(history, world, moments, pasts, findings).check(matched)
    Reacting(history, world, moments, pasts, findings).check(matched)
    emitting.check(matched)
    Modifying(history, findings).check(matched)
    Overriding(history, findings).check(matched)
    Constraining(plan, history, world, findings).check(matched)
    Variables(history, world, findings).check()
    FixedActions(plan, history, world, findings).check(matched)
    _check_verdict(plan, history, matched, findings)


def _check_verdict(plan: Plan, history: History, matched: Matched, findings: Findings) -> None:
    """The run ends as the behavior that is all of it."""
    root, status = history.root, history.end["status"]
    span = plan.scenarios[plan.entry].span
    if history.is_exact and root.start.t != 0:
        findings.violate(Rule.DIRECT, f"the run begins at {root.start.t:g} s", span, 0, root.start.seq)
    if history.end["t"] != root.end.t:
        message = f"the run ends at {history.end['t']:g} s, and its scenario at {root.end.t:g} s"
        findings.violate(Rule.DIRECT, message, span, root.end.seq, history.end["seq"])
    if status == "failed" and root.status == CANCELLED and not _waits(history):
        message = "the run failed, its scenario was cancelled, and nothing waits in it"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, history.end["seq"])
    is_overridden = status == "passed" and was_overridden([root], matched.overridden)
    if status not in ("error", "cancelled", _ENDS.get(root.status)) and not is_overridden:
        message = f"the run {status}, and its scenario {root.status}"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, history.end["seq"])


def _waits(history: History) -> bool:
    """Whether something still waited at the end of the run: then nothing could happen any more."""
    return any(child.status == CANCELLED and child.end.t == history.root.end.t for child in history.root.children)


def _number(place: int, record: Mapping[str, Any]) -> int:
    """The `seq` of a record; where that is missing, its place."""
    told = record.get("seq")
    return told if isinstance(told, int) else place
