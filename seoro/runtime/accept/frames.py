"""Behaviors of the trace, matched with those of the plan.

A **frame** is the stretch of the trace in which a behavior runs, as seen by its surroundings: the whole behavior,
or one attempt of a modifier. A layer in between may hold it (`until`, the lower bound of a `duration`), so that it
lasts longer than its content, or cut it short. The content has an **end** of its own, which the end of the frame
has to match.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf

from seoro.lang import plan as plan_
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.history import History, Mark, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.layers import Duration, Untils
from seoro.runtime.values.environment import Environment

CANCELLED, SUCCEEDED, FAILED = "cancelled", "succeeded", "failed"


@dataclass(frozen=True, eq=False)
class Frame:
    """Stretch of the trace in which a behavior runs.

    Args:
        node: Behavior or modifier that contains the content.
        owner: The behavior itself.
        start: Its start.
        end: Its end.
        status: Its end state.
        children: Contained behaviors.
        around: Scenario that contains the behavior.
        cuts: End states, of all, in which it may have been cut short.
        loosened: Number of layers by which it may outlast its content.
        is_secondary: Whether its surroundings may end it with success.
    """

    node: Node
    owner: Node
    start: Mark
    end: Mark
    status: str
    children: tuple[Node, ...]
    around: Instance
    cuts: frozenset[str] = frozenset({CANCELLED})
    loosened: int = 0
    is_secondary: bool = False

    def loose(self, *cuts: str) -> Frame:
        """Return the frame of content that may be held or cut short in further ways."""
        return replace(self, cuts=self.cuts.union(cuts), loosened=self.loosened + 1)

    @property
    def held(self) -> bool:
        """Whether it may outlast its content."""
        return self.loosened > 0

    @property
    def records(self) -> tuple[int, int]:
        """Numbers of its first and last record."""
        return self.start.seq, self.end.seq


@dataclass(frozen=True)
class End:
    """End of the content of a frame.

    Args:
        status: Succeeded or failed; None if it has not ended.
        t: Time of the end; without a status, the time at which it stopped [s].
        records: Records that show it.
    """

    status: str | None
    t: float = inf
    records: tuple[int, ...] = ()


UNKNOWN = End("unknown")  # overridden, or not in the trace


@dataclass(eq=False)
class Matched:
    """Matched behaviors: places in the trace where rules apply."""

    plans: dict[int, plan_.Behavior] = field(default_factory=dict)  # by number of the behavior
    waits: list[tuple[plan_.Wait, Node, Instance]] = field(default_factory=list)
    emits: list[tuple[plan_.Emit, Node, Instance]] = field(default_factory=list)
    untils: list[tuple[Untils, Frame, Environment]] = field(default_factory=list)
    durations: list[tuple[Duration, Frame, Instance | None]] = field(default_factory=list)
    modifiers: list[tuple[plan_.ModifierApplication, plan_.Modifier, Node, Environment]] = field(
        default_factory=list
    )
    overrides: list[tuple[plan_.Override, Frame, Instance]] = field(default_factory=list)
    invocations: list[tuple[plan_.InvokeScenario | plan_.InvokeAction | None, Instance, Instance]] = field(
        default_factory=list
    )
    executions: list[tuple[Instance, Frame]] = field(default_factory=list)
    labels: list[tuple[str, Node, Instance]] = field(default_factory=list)
    reactions: list[tuple[Instance, plan_.On, tuple[Node, ...]]] = field(default_factory=list)
    around: dict[int, Instance] = field(default_factory=dict)  # surrounding scenarios, by number of the behavior

    @property
    def overridden(self) -> frozenset[str]:
        """Labels of behaviors that overrides may end."""
        return frozenset(override.overridden[-1] for override, _, _ in self.overrides)


def kind_of(behavior: plan_.Behavior) -> str:
    """Return the kind of a behavior, as in the trace."""
    return _KINDS[type(behavior)]


_KINDS: Mapping[type[plan_.Behavior], str] = {
    plan_.Serial: "serial",
    plan_.Parallel: "parallel",
    plan_.OneOf: "one_of",
    plan_.Wait: "wait",
    plan_.Emit: "emit",
    plan_.CallMethod: "call",
    plan_.InvokeAction: "action",
    plan_.InvokeScenario: "scenario",
}


def title_of(behavior: plan_.Behavior) -> str:
    """Return the name of a behavior for messages."""
    if behavior.label:
        return behavior.label
    match behavior:
        case plan_.InvokeAction(action=name) | plan_.InvokeScenario(scenario=name):
            return name
        case _:
            return kind_of(behavior)


Location = tuple[str, str, str]
"""Place in a scenario: file, line, column; the folder may have been renamed since the run."""


def recorded_location(node: Node) -> Location:
    """Return the place in a record."""
    recorded, _, column = node.source.rpartition(":")
    name, _, line = recorded.rpartition(":")
    return name.replace("\\", "/").rpartition("/")[2], line, column


def location_of(span: Span) -> Location:
    """Return the place of a text."""
    return span.file.name.replace("\\", "/").rpartition("/")[2], str(span.line), str(span.column)


def stands_at(node: Node, span: Span) -> bool:
    """Whether a record is from a place in the scenario."""
    return recorded_location(node) == location_of(span)


def is_of(node: Node, behavior: plan_.Behavior) -> bool:
    """Whether a behavior of the trace is a given one of the plan."""
    return node.type == kind_of(behavior) and stands_at(node, behavior.span)


def check_end(frame: Frame, end: End, rule: Rule, span: Span, history: History, findings: Findings) -> None:
    """Check that the end of a frame matches the end of its content.

    Args:
        frame: The frame.
        end: End of the content.
        rule: The rule to report.
        span: Place of the content in the scenario.
        history: The trace.
        findings: Collects violations.
    """
    if end is UNKNOWN:
        return
    shown = (*frame.records, *end.records)
    if end.status is None:
        if frame.status not in frame.cuts:
            findings.violate(rule, f"it {frame.status} before its content has ended", span, *shown)
        elif end.t < inf and frame.loosened < 2 and not history.lasts(end.t, frame.end.t):
            findings.violate(rule, f"it stopped at {end.t:g} s, but was not ended then", span, *shown)
        return
    is_then = history.lasts(end.t, frame.end.t)
    if not is_then and (end.status == FAILED or not frame.held):
        findings.violate(
            rule, f"its content {end.status} at {end.t:g} s, but it ends at {frame.end.t:g} s", span, *shown
        )
    elif frame.status != end.status and not (
        frame.status in frame.cuts and (is_then or frame.status == CANCELLED)
    ):
        findings.violate(Rule.OUTCOME, f"it {ended(frame.status)}, but its content {end.status}", span, *shown)


def ended(status: str) -> str:
    """Describe the end of a behavior with a state."""
    return "was cancelled" if status == CANCELLED else status


def emits_of_end(instance: Instance) -> list[plan_.Emit]:
    """Return all `emit end` and `emit fail` in the text of a scenario."""
    declared = instance.declaration
    found = [member for directive in declared.on for member in directive.members if isinstance(member, plan_.Emit)]
    if isinstance(declared, plan_.Scenario):
        found += [each for each in plan_.behaviors_in(declared.body) if isinstance(each, plan_.Emit)]
    return [emit for emit in found if is_ending(emit)]


def is_ending(emit: plan_.Emit) -> bool:
    """Whether an `emit` ends its scenario."""
    event = emit.event
    return isinstance(event, plan_.PhaseEvent) and event.label is None and event.phase is not plan_.Phase.START


def ending_emit(instance: Instance, frame: Frame) -> Node | None:
    """Return the executed `emit end` or `emit fail` of an instance within a frame."""
    for start in emits_of_end(instance):
        pending = [*frame.node.children]
        while pending:
            node = pending.pop()
            if node.type == "emit" and stands_at(node, start.span):
                return node
            pending += node.children
    return None


def is_modifier(application: plan_.ModifierApplication, node: Node) -> bool:
    """Whether a behavior of the trace is the modifier of an application."""
    return node.type == "modifier" and node.name == application.modifier and stands_at(node, application.span)


def modifier_of_held(frame: Frame, plan: plan_.Plan) -> plan_.ModifierApplication | None:
    """Return the next modifier of a held struct or actor in a frame."""
    nodes = [child for child in frame.children if child.type == "modifier"]
    for type_ in plan.objects.values():
        for applied in type_.modifiers:
            if isinstance(applied, plan_.ModifierApplication) and any(
                is_modifier(applied, node) for node in nodes
            ):
                return applied
    return None
