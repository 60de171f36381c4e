"""Behaviors of the trace, matched with those of the plan.

A **frame** is a stretch of the trace in which a behavior is carried out, as something around it sees it: the
whole behavior, or one attempt of a modifier. Something that lies between may hold it (`until`, the lower bound of
a `duration`), so that it lasts longer than what it carries out, or cut it short. What it carries out has an
**end** of its own, with which that of the frame has to agree.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf

from seoro.lang.plan import (
    Behavior,
    CallMethod,
    Emit,
    InvokeAction,
    InvokeScenario,
    Modifier,
    ModifierApplication,
    On,
    OneOf,
    Override,
    Parallel,
    Phase,
    PhaseEvent,
    Scenario,
    Serial,
    Wait,
)
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.history import History, Mark, Node
from seoro.runtime.accept.layers import Duration, Untils
from seoro.runtime.accept.world import Instance
from seoro.runtime.environment import Environment

CANCELLED, SUCCEEDED, FAILED = "cancelled", "succeeded", "failed"


@dataclass(frozen=True, eq=False)
class Frame:
    """A stretch of the trace in which a behavior is carried out.

    Args:
        node: In which what it carries out lies: a behavior or a modifier.
        owner: The behavior itself.
        start: Its start.
        end: Its end.
        status: How it ended.
        children: What lies in it.
        around: The scenario that contains the behavior.
        cuts: The ways to end, of all, in which it may have been ended in the midst.
        loosened: By how many layers it may last longer than what it carries out.
        is_secondary: Whether something around the behavior may end it, and it has succeeded then.
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
        """The same, of what may be held, and be ended in the midst in other ways, too."""
        return replace(self, cuts=self.cuts.union(cuts), loosened=self.loosened + 1)

    @property
    def held(self) -> bool:
        """Whether it may last longer than what it carries out."""
        return self.loosened > 0

    @property
    def records(self) -> tuple[int, int]:
        """The numbers of the records that bound it."""
        return self.start.seq, self.end.seq


@dataclass(frozen=True)
class End:
    """The end that what a frame carries out has by itself.

    Args:
        status: Succeeded or failed; None if it had not ended.
        t: When it ended, or, without a status, when it went on no more [s].
        records: What shows that.
    """

    status: str | None
    t: float = inf
    records: tuple[int, ...] = ()


UNKNOWN = End("unknown")  # it was overridden, or is told by nothing


@dataclass(eq=False)
class Matched:
    """What was matched: places in the trace where rules apply."""

    plans: dict[int, Behavior] = field(default_factory=dict)  # by number of the behavior
    waits: list[tuple[Wait, Node, Instance]] = field(default_factory=list)
    emits: list[tuple[Emit, Node, Instance]] = field(default_factory=list)
    untils: list[tuple[Untils, Frame, Environment]] = field(default_factory=list)
    durations: list[tuple[Duration, Frame, Instance | None]] = field(default_factory=list)
    modifiers: list[tuple[ModifierApplication, Modifier, Node, Environment]] = field(default_factory=list)
    overrides: list[tuple[Override, Frame, Instance]] = field(default_factory=list)
    invocations: list[tuple[InvokeScenario | InvokeAction | None, Instance, Instance]] = field(
        default_factory=list
    )
    executions: list[tuple[Instance, Frame]] = field(default_factory=list)
    labels: list[tuple[str, Node, Instance]] = field(default_factory=list)
    reactions: list[tuple[Instance, On, tuple[Node, ...]]] = field(default_factory=list)
    around: dict[int, Instance] = field(default_factory=dict)  # scenarios around behaviors, by number

    @property
    def overridden(self) -> frozenset[str]:
        """The labels of what overrides may end."""
        return frozenset(override.overridden[-1] for override, _, _ in self.overrides)


def kind_of(behavior: Behavior) -> str:
    """What the trace calls the kind of a behavior."""
    match behavior:
        case Serial():
            return "serial"
        case Parallel():
            return "parallel"
        case OneOf():
            return "one_of"
        case Wait():
            return "wait"
        case Emit():
            return "emit"
        case CallMethod():
            return "call"
        case InvokeAction():
            return "action"
        case InvokeScenario():
            return "scenario"


def title_of(behavior: Behavior) -> str:
    """What people call a behavior."""
    if behavior.label:
        return behavior.label
    match behavior:
        case InvokeAction(action=name) | InvokeScenario(scenario=name):
            return name
        case _:
            return kind_of(behavior)


Location = tuple[str, str, str]
"""A place in a scenario: file, line, column; the folder may have another name than it had when it was run."""


def location_told(node: Node) -> Location:
    """The place that a record is of."""
    told, _, column = node.source.rpartition(":")
    name, _, line = told.rpartition(":")
    return name.replace("\\", "/").rpartition("/")[2], line, column


def location_of(span: Span) -> Location:
    """The place of a text."""
    return span.file.name.replace("\\", "/").rpartition("/")[2], str(span.line), str(span.column)


def stands_at(node: Node, span: Span) -> bool:
    """Whether a record is of a place in the scenario."""
    return location_told(node) == location_of(span)


def is_of(node: Node, behavior: Behavior) -> bool:
    """Whether a behavior of the trace is one of the plan."""
    return node.type == kind_of(behavior) and stands_at(node, behavior.span)


def check_end(frame: Frame, end: End, rule: Rule, span: Span, history: History, findings: Findings) -> None:
    """The end of a frame has to agree with the end of what it carries out.

    Args:
        frame: The frame.
        end: The end of what it carries out.
        rule: Which rule that is about.
        span: Its place in the scenario.
        history: The trace.
        findings: Gets what is wrong.
    """
    if end is UNKNOWN:
        return
    shown = (*frame.records, *end.records)
    if end.status is None:
        if frame.status not in frame.cuts:
            findings.violate(rule, f"it {frame.status} before all of it was carried out", span, *shown)
        elif end.t < inf and frame.loosened < 2 and not history.lasts(end.t, frame.end.t):
            findings.violate(rule, f"it did not go on at {end.t:g} s, and was not ended then", span, *shown)
        return
    is_then = history.lasts(end.t, frame.end.t)
    if not is_then and (end.status == FAILED or not frame.held):
        findings.violate(
            rule,
            f"what it carries out {end.status} at {end.t:g} s, and it ends at {frame.end.t:g} s",
            span,
            *shown,
        )
    elif frame.status != end.status and not (
        frame.status in frame.cuts and (is_then or frame.status == CANCELLED)
    ):
        findings.violate(
            Rule.OUTCOME, f"it {_ended(frame.status)}, but what it carries out {end.status}", span, *shown
        )


def _ended(status: str) -> str:
    return "was cancelled" if status == CANCELLED else status


def emits_of_end(instance: Instance) -> list[Emit]:
    """Where the text of a scenario emits its own `end` or `fail`."""
    declared = instance.declaration
    found = [member for directive in declared.on for member in directive.members if isinstance(member, Emit)]
    pending = [declared.body] if isinstance(declared, Scenario) and declared.body is not None else []
    while pending:
        behavior = pending.pop()
        if isinstance(behavior, Emit):
            found.append(behavior)
        elif isinstance(behavior, Serial | Parallel | OneOf):
            pending += behavior.members
    return [emit for emit in found if is_ending(emit)]


def is_ending(emit: Emit) -> bool:
    """Whether it ends the scenario in which it stands."""
    event = emit.event
    return isinstance(event, PhaseEvent) and event.label is None and event.phase is not Phase.START
