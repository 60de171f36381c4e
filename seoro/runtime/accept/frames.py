"""Behaviors of the trace, matched with those of the plan.

A **frame** is the stretch of the trace in which a behavior runs, as seen by its surroundings: the whole behavior,
or one attempt of a modifier. A layer in between may hold it (`until`, the lower bound of a `duration`), so that it
lasts longer than its content, or cut it short. The content has an **end** of its own, which the end of the frame
has to match.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf

from seoro.lang import plan as plan_
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.history import History, Mark, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.layers import Duration, Untils
from seoro.runtime.accept.world import World
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
    def is_cut_at_once(self) -> bool:
        """Whether it may have been cut short before its content has started."""
        return self.start.t == self.end.t and self.status in self.cuts

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

    @property
    def all_emits(self) -> Iterator[tuple[plan_.Emit, Node, Instance]]:
        """All emissions, by members and by reactions."""
        yield from self.emits
        for instance, _, nodes in self.reactions:
            for node in nodes:
                plan = self.plans.get(node.number)
                if isinstance(plan, plan_.Emit):
                    yield plan, node, instance

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


@dataclass(eq=False)
class Checker:
    """Base of the checks of a trace.

    Args:
        world: The trace, with its values.
    """

    world: World

    @property
    def history(self) -> History:
        """The trace."""
        return self.world.history

    @property
    def findings(self) -> Findings:
        """Collects violations."""
        return self.world.findings

    def was_overridden(self, node: Node) -> bool:
        """Whether an `override` may have cancelled a behavior, directly or within it."""
        return was_overridden([node], self.world.overridden)

    def end_of(self, node: Node) -> End:
        """Return the end of a behavior as the end of the frame around it."""
        if node.status == CANCELLED:
            return UNKNOWN if self.was_overridden(node) else End(None, node.end.t, node.records)
        return End(node.status, node.end.t, node.records)

    def check_end(self, frame: Frame, end: End, rule: Rule, span: Span) -> None:
        """Check that the end of a frame matches the end of its content.

        Args:
            frame: The frame.
            end: End of the content.
            rule: The rule to report.
            span: Place of the content in the scenario.
        """
        if end is UNKNOWN:
            return
        violate, lasts = self.findings.violate, self.history.lasts
        shown = (*frame.records, *end.records)
        if end.status is None:
            if frame.status not in frame.cuts:
                violate(rule, f"it {frame.status} before its content has ended", span, *shown)
            elif end.t < inf and frame.loosened < 2 and not lasts(end.t, frame.end.t):
                violate(rule, f"it stopped at {end.t:g} s, but was not ended then", span, *shown)
            return
        is_then = lasts(end.t, frame.end.t)
        if not is_then and (end.status == FAILED or not frame.held):
            message = f"its content {end.status} at {end.t:g} s, but it ends at {frame.end.t:g} s"
            violate(rule, message, span, *shown)
        elif frame.status != end.status and not (
            frame.status in frame.cuts and (is_then or frame.status == CANCELLED)
        ):
            violate(Rule.OUTCOME, f"it {ended(frame.status)}, but its content {end.status}", span, *shown)


def was_overridden(nodes: Iterable[Node], overridden: frozenset[str]) -> bool:
    """Whether an `override` may have cancelled one of the behaviors, directly or within it.

    Args:
        nodes: The behaviors.
        overridden: Labels of behaviors that an `override` may end.
    """
    pending = list(nodes) if overridden else []
    while pending:
        found = pending.pop()
        if found.status == CANCELLED:
            if found.name in overridden:
                return True
            pending += found.children
    return False


def ended(status: str) -> str:
    """Describe the end of a behavior with a state."""
    return "was cancelled" if status == CANCELLED else status


def is_ending(emit: plan_.Emit) -> bool:
    """Whether an `emit` ends its scenario."""
    event = emit.event
    return isinstance(event, plan_.PhaseEvent) and event.label is None and event.phase is not plan_.Phase.START


def ends_by_emit(instance: Instance, frame: Frame) -> bool:
    """Whether an `emit end` or `emit fail` of an instance was executed within a frame."""
    declared = instance.declaration
    found: list[plan_.Behavior] = [member for directive in declared.on for member in directive.members]
    if isinstance(declared, plan_.Scenario):
        found += plan_.behaviors_in(declared.body)
    emits = [each for each in found if isinstance(each, plan_.Emit) and is_ending(each)]
    pending = [*frame.node.children] if emits else []
    while pending:
        node = pending.pop()
        if any(is_of(node, emit) for emit in emits):
            return True
        pending += node.children
    return False


def is_modifier(application: plan_.ModifierApplication, node: Node) -> bool:
    """Whether a behavior of the trace is the modifier of an application."""
    return node.type == "modifier" and node.name == application.modifier and stands_at(node, application.span)


def modifier_of_held(frame: Frame, plan: plan_.Plan) -> plan_.ModifierApplication | None:
    """Return the next modifier of a held struct or actor in a frame."""
    nodes = [child for child in frame.children if child.type == "modifier"]
    held = (each for type_ in plan.objects.values() for each in type_.modifiers)
    applied = (each for each in held if isinstance(each, plan_.ModifierApplication))
    return next((each for each in applied if any(is_modifier(each, node) for node in nodes)), None)
