"""The static tree of a run: the behaviors that its trace may contain, before any of them starts.

It has the behaviors of the entry scenario and of every scenario that can be invoked from it, each scenario once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from seoro.lang.frozen import Value
from seoro.lang.plan import Behavior, InvokeScenario, Plan, Scenario
from seoro.lang.plan.behaviors import Composition
from seoro.lang.source import SourceFile, Span
from seoro.runtime.execution.names import name_of, type_of
from seoro.runtime.trace.sources import sources

FORMAT: Final = "1.1"  # of traces; those of 1.0 have no such field, and their readers can read this one
MAX_NODES: Final = 10_000  # further behaviors are omitted


class StaticTree(Value):
    """The static tree of a plan.

    Args:
        nodes: Behaviors in source order, as plain data.
        places: Fields of the start of a behavior by its identity: `node`, an index in `nodes`, and its span.
        omitted: Number of behaviors beyond `MAX_NODES`.
    """

    nodes: tuple[dict[str, Any], ...]
    places: Mapping[int, Mapping[str, Any]]
    omitted: int

    def fields(self, files: Sequence[SourceFile]) -> dict[str, Any]:
        """Return the fields of `run.start` that describe the text of the scenario.

        Args:
            files: The files of the scenario; empty if it has none.
        """
        found: dict[str, Any] = {"format": FORMAT, "tree": list(self.nodes)}
        if files:
            found["sources"] = sources(files)
        if self.omitted:
            found["tree_omitted"] = self.omitted
        return found


def static_tree(plan: Plan) -> StaticTree:
    """Return the static tree of a plan."""
    nodes: list[dict[str, Any]] = []
    places: dict[int, dict[str, Any]] = {}
    omitted = 0
    for scenario in _scenarios(plan):
        for behavior, parent in (*_behaviors(scenario), *((each, None) for each in _reactions(scenario))):
            if len(nodes) == MAX_NODES:
                omitted += 1
                continue
            around = None if parent is None else places[id(parent)]["node"]
            places[id(behavior)] = found = {"node": len(nodes), **place(behavior.span)}
            span = {"source": found["source"], "source_end": found["source_end"]}
            own = {"id": len(nodes), "parent": around, "scenario": scenario.name}
            nodes.append({**own, **_described(behavior), **span, **_invoked(behavior)})
    return StaticTree(tuple(nodes), places, omitted)


def behaviors_of_plan(plan: Plan) -> Iterator[tuple[str, Behavior]]:
    """Yield all behaviors of a plan without its reactions, with the names of their scenarios."""
    for scenario in _scenarios(plan):
        for behavior, _ in _behaviors(scenario):
            yield scenario.name, behavior


def _scenarios(plan: Plan) -> Iterator[Scenario]:
    """Yield the entry scenario, then the others."""
    yield plan.scenarios[plan.entry]
    for name, scenario in plan.scenarios.items():
        if name != plan.entry:
            yield scenario


def _behaviors(scenario: Scenario) -> Iterator[tuple[Behavior, Behavior | None]]:
    """Yield the behaviors of a scenario with the composition around each, in source order."""
    pending: list[tuple[Behavior, Behavior | None]] = [] if scenario.body is None else [(scenario.body, None)]
    while pending:
        behavior, parent = pending.pop()
        yield behavior, parent
        if isinstance(behavior, Composition):
            pending += ((member, behavior) for member in reversed(behavior.members))


def _reactions(scenario: Scenario) -> Iterator[Behavior]:
    """Yield the members of the reactions of a scenario."""
    for directive in scenario.on:
        yield from directive.members


def _described(behavior: Behavior) -> dict[str, str]:
    return {"type": type_of(behavior), "name": name_of(behavior)}


def _invoked(behavior: Behavior) -> dict[str, str]:
    return {"invokes": behavior.scenario} if isinstance(behavior, InvokeScenario) else {}


def place(span: Span) -> dict[str, str]:
    """Return the start and the end of a span, as in records: `file:line:column`, and `line:column` after it."""
    line, column = span.file.position(span.end)
    return {"source": str(span), "source_end": f"{line}:{column}"}
