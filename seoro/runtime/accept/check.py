"""Check of a trace: reads it, matches it with the plan, and applies all rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.lang.plan import Plan
from seoro.runtime.accept.channels import Channels
from seoro.runtime.accept.constraining import ValueChecker, VariableChecker
from seoro.runtime.accept.emitting import EventChecker
from seoro.runtime.accept.findings import Acceptance, Findings, Rule
from seoro.runtime.accept.fixed_actions import ActionChecker
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Matched, was_overridden
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
        _check(World(plan, history, findings))
    return findings.acceptance([_number(place, record) for place, record in enumerate(records)])


def _check(world: World) -> None:
    matched = Tree(world).match()
    if matched is None:
        return
    channels = Channels(world)
    moments = Moments(world, channels, Pasts(matched, channels))
    WaitChecker(world, moments).check(matched)
    ReactionChecker(world, moments).check(matched)
    EventChecker(world, moments).check(matched)
    ModifierChecker(world).check(matched)
    OverrideChecker(world).check(matched)
    ValueChecker(world).check(matched)
    VariableChecker(world).check()
    ActionChecker(world).check(matched)
    _check_verdict(world, matched)


def _check_verdict(world: World, matched: Matched) -> None:
    """Check that the run ends as its root behavior."""
    history, findings = world.history, world.findings
    root, end, status = history.root, history.end, history.end["status"]
    span = world.plan.scenarios[world.plan.entry].span
    if history.is_exact and root.start.t != 0:
        findings.violate(Rule.DIRECT, f"the run begins at {root.start.t:g} s", span, 0, root.start.seq)
    if end["t"] != root.end.t:
        message = f"the run ends at {end['t']:g} s, but its scenario at {root.end.t:g} s"
        findings.violate(Rule.DIRECT, message, span, root.end.seq, end["seq"])
    waits = any(child.status == CANCELLED and child.end.t == root.end.t for child in root.children)
    if status == "failed" and root.status == CANCELLED and not waits:  # otherwise, the run was stuck
        message = "the run failed with a cancelled scenario, but no behavior was waiting"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, end["seq"])
    is_overridden = status == "passed" and was_overridden([root], matched.overridden)
    if status not in ("error", "cancelled", _ENDS.get(root.status)) and not is_overridden:
        message = f"the run {status}, but its scenario {root.status}"
        findings.violate(Rule.OUTCOME, message, span, root.end.seq, end["seq"])


def _number(place: int, record: Mapping[str, Any]) -> int:
    """Return the `seq` of a record; if missing, its index."""
    recorded = record.get("seq")
    return recorded if isinstance(recorded, int) else place
