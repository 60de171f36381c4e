"""Checking a trace: reading it, matching it with the plan, and all rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.lang.plan import Plan
from seoro.runtime.accept.findings import Acceptance, Findings
from seoro.runtime.accept.structure import read_history
from seoro.runtime.accept.tree import Tree
from seoro.runtime.accept.world import World


def check_trace(plan: Plan, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Whether a trace is accepted by a scenario.

    Args:
        plan: The scenario that was run, lowered with the same entry.
        records: The records of the trace, as observers see them or as JSON has them.
    """
    findings = Findings()
    history = read_history(records, findings)
    if history is not None:
        world = World(plan, history, findings)
        Tree(plan, history, world, findings).match()
    return findings.acceptance([_number(place, record) for place, record in enumerate(records)])


def _number(place: int, record: Mapping[str, Any]) -> int:
    """The `seq` of a record; where that is missing, its place."""
    told = record.get("seq")
    return told if isinstance(told, int) else place
