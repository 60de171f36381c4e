"""Matching of the behaviors of a trace with those of the plan, from the outside to the inside (7.6.1.4).

Each behavior of the trace must be one that the scenario invokes at that place. Its layers (`until`, modifiers, its
duration) are removed one by one; then its members are matched, and their order and times checked. Rules that need
more data receive the places where they apply.
"""

from __future__ import annotations

from bisect import bisect, insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter
from typing import TypeAlias

from seoro.lang import plan as plan_
from seoro.lang.source import Span
from seoro.runtime.accept.compositions import CompositionChecker, OneOfChecker, SerialChecker
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.frames import (
    CANCELLED,
    FAILED,
    SUCCEEDED,
    Checker,
    End,
    Frame,
    Matched,
    ends_by_emit,
    is_modifier,
    is_of,
    modifier_of_held,
    title_of,
)
from seoro.runtime.accept.history import Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.layers import Duration, Layer, Untils, layers_in, layers_of, layers_of_run
from seoro.runtime.accept.parallels import ParallelChecker
from seoro.runtime.accept.running import (
    Reactions,
    environment_in,
    late_reactions,
    override_scope,
    running_instance,
)
from seoro.runtime.accept.timing import Timing

_Matched: TypeAlias = plan_.Behavior | None  # None for the run itself


@dataclass(eq=False)
class Tree(Checker):
    """Matches a trace with a plan."""

    matched: Matched = field(default_factory=Matched)
    _pending: list[Callable[[], None]] = field(default_factory=list)
    _executed: set[int] = field(default_factory=set)  # numbers of instances

    def match(self) -> Matched | None:
        """Match the whole trace; return None if it is from another scenario."""
        root = self.history.root
        if root.type != "scenario" or root.name != self.world.plan.entry:
            message = f"the run is `{root.name}`; expected the scenario `{self.world.plan.entry}`"
            self.findings.violate(Rule.TREE, message, None, root.start.seq)
            return None
        entry = self.world.instances.get(root.instances[0]) if root.instances else None
        if entry is None:
            self.findings.violate(Rule.STRUCTURE, "the values of the run are missing", None, root.start.seq)
            return None
        frame = Frame(root, root, root.start, root.end, root.status, tuple(root.children), entry)
        self._layers(None, layers_of_run(self.world.plan), frame)
        while self._pending:
            self._pending.pop()()
        return self.matched

    # -------------------------------------------------------- behaviors

    def _behavior(self, plan: plan_.Behavior, node: Node, around: Instance, cuts: frozenset[str]) -> None:
        """Match a behavior with its plan."""
        self.matched.plans[node.number] = plan
        if node.name != title_of(plan) and plan.label is not None:
            message = f"it is named `{node.name}`; expected the label `{plan.label}`"
            self.findings.violate(Rule.TREE, message, plan.span, node.start.seq)
        if plan.label is not None:
            self.matched.labels.append((plan.label, node, around))
        children, is_secondary = tuple(node.children), SUCCEEDED in cuts
        frame = Frame(node, node, node.start, node.end, node.status, children, around, cuts, 0, is_secondary)
        match plan:
            case plan_.Wait():
                self._alone(node, plan)
                self.matched.waits.append((plan, node, around))
            case plan_.Emit():
                self._zero_time(node, plan)
                self.matched.emits.append((plan, node, around))
            case plan_.CallMethod():
                self._zero_time(node, plan)
            case plan_.InvokeAction() | plan_.InvokeScenario():
                for number in node.instances:
                    if number in self.world.instances:
                        self._invoked(plan, self.world.instances[number], node, around)
                self._layers(plan, layers_of(plan, self.world.plan), frame)
            case plan_.Serial() | plan_.Parallel() | plan_.OneOf():
                self._layers(plan, layers_of(plan, self.world.plan), frame)

    def _invoked(
        self, plan: plan_.InvokeAction | plan_.InvokeScenario, instance: Instance, node: Node, around: Instance
    ) -> None:
        """Match an instance with the invocation that made it."""
        instance.node = node
        self.matched.invocations.append((plan, instance, around))
        if plan.label is not None:
            insort(around.labels.setdefault(plan.label, []), instance, key=attrgetter("seq"))
        name = plan.action if isinstance(plan, plan_.InvokeAction) else plan.scenario
        if instance.declaration.name != name:
            message = f"`{instance.declaration.name}` is invoked; expected `{name}`"
            self.findings.violate(Rule.DIRECT, message, plan.span, node.start.seq, instance.seq)

    def _alone(self, node: Node, plan: plan_.Behavior) -> None:
        for child in node.children:
            self.findings.violate(Rule.TREE, f"`{child.name}` is not part of it", plan.span, child.start.seq)

    def _zero_time(self, node: Node, plan: plan_.Behavior) -> None:
        """Check a behavior that takes no time: it succeeds, or the run ends as an error."""
        self._alone(node, plan)
        if node.start.t != node.end.t:
            message = f"it takes {node.end.t - node.start.t:g} s; expected no time"
            self.findings.violate(Rule.EMIT, message, plan.span, *node.records)
        if node.status != SUCCEEDED and self.history.end["status"] != "error":
            message = f"`{node.name}` takes no time and can only succeed"
            self.findings.violate(Rule.OUTCOME, message, plan.span, *node.records)

    # -------------------------------------------------------- layers

    def _layers(self, behavior: _Matched, layers: Sequence[Layer], frame: Frame) -> None:
        """Remove the layers around a behavior, the outermost first."""
        for position, layer in enumerate(layers):
            match layer:
                case Untils():
                    self.matched.untils.append((layer, frame, environment_in(frame, self.world)))
                    frame = frame.loose(SUCCEEDED)
                case Duration():
                    self.matched.durations.append((layer, frame, running_instance(frame, self.world)))
                    frame = frame.loose(SUCCEEDED, FAILED)
                case plan_.Override():
                    self.matched.overrides.append((layer, frame, override_scope(layer, frame, self.world)))
                case plan_.ModifierApplication():
                    self._modifier(behavior, layer, layers[position + 1 :], frame)
                    return
        self._core(behavior, frame)

    def _modifier(
        self, behavior: _Matched, layer: plan_.ModifierApplication, rest: Sequence[Layer], frame: Frame
    ) -> None:
        what = f"the modifier `{layer.modifier}`"
        node = self._only_child(frame, Rule.MODIFIER, what, layer.span, partial(is_modifier, layer))
        if node is None:
            return
        modifier = self.world.plan.modifiers[layer.modifier]
        self.matched.modifiers.append((layer, modifier, node, environment_in(frame, self.world)))
        self.check_end(frame, self.end_of(node), Rule.MODIFIER, layer.span)
        reactions = Reactions(modifier, node, self.history)
        children = tuple(child for child in node.children if child not in reactions.nodes)
        is_ended = bool(reactions.endings)
        cuts = frozenset({CANCELLED, SUCCEEDED, FAILED} if is_ended else {CANCELLED})
        around, secondary = frame.around, frame.is_secondary or is_ended
        inside = Frame(node, frame.owner, node.start, node.end, node.status, children, around, cuts, 0, secondary)
        if is_ended:
            reactions.check_end(inside, self.findings)
        if modifier.library is None and not node.attempts:  # otherwise implemented in Python
            if not children and node.status == FAILED:
                return  # its function failed before it ran the behavior
            inside = replace(inside, cuts=inside.cuts | frame.cuts)
            self._pending.append(partial(self._layers, behavior, (*layers_in(modifier.modifiers), *rest), inside))
            return
        starts = [child.start.seq for child in children]
        for attempt in node.attempts:
            first, last = (bisect(starts, mark.seq) for mark in (attempt.start, attempt.end))
            within = children[first:last]
            again = replace(inside, start=attempt.start, end=attempt.end, status=attempt.status, children=within)
            self._pending.append(partial(self._layers, behavior, rest, again))

    def _only_child(
        self, frame: Frame, rule: Rule, what: str, span: Span, is_it: Callable[[Node], bool]
    ) -> Node | None:
        """Return the only behavior in a frame; None if the frame ended before that started."""
        found = [child for child in frame.children if is_it(child)]
        for other in [child for child in frame.children if child not in found] + found[1:]:
            self.findings.violate(rule, f"`{other.name}` runs besides {what}", span, other.start.seq)
        if not found:
            self.check_end(frame, End(None, frame.start.t), rule, span)
            return None
        if found[0].start.t != frame.start.t:
            message = f"{what} starts at {found[0].start.t:g} s; expected {frame.start.t:g} s"
            self.findings.violate(rule, message, span, frame.start.seq, found[0].start.seq)
        return found[0]

    # -------------------------------------------------------- content

    def _span(self, behavior: _Matched) -> Span:
        """Return the place of a behavior in the scenario; None is the run itself."""
        return behavior.span if behavior is not None else self.world.plan.scenarios[self.world.plan.entry].span

    def _core(self, behavior: _Matched, frame: Frame) -> None:
        match behavior:
            case None | plan_.InvokeScenario() | plan_.InvokeAction():
                held = modifier_of_held(frame, self.world.plan)
                if held is None:
                    self._invocation(behavior, frame)
                else:
                    self._modifier(behavior, held, (), frame)
                return
            case plan_.Serial():
                checker: CompositionChecker = SerialChecker(self.world, behavior, frame)
            case plan_.OneOf():
                checker = OneOfChecker(self.world, behavior, frame)
            case plan_.Parallel():
                checker = ParallelChecker(self.world, behavior, frame, Timing(self.world, self.matched))
            case _:
                return
        self.check_end(frame, checker.end(), checker.rule, behavior.span)
        for index, node in checker.nodes.items():
            may_be_ended = index > 0 and checker.may_end_secondaries
            cuts = frozenset({CANCELLED, SUCCEEDED} if may_be_ended else {CANCELLED})
            member = behavior.members[index]
            self._pending.append(partial(self._behavior, member, node, frame.around, cuts))

    def _invocation(self, behavior: _Matched, frame: Frame) -> None:
        """Match an instance: the `do` of a scenario, and reactions."""
        owner, span = frame.owner, self._span(behavior)
        instance = running_instance(frame, self.world)
        if instance is None or (instance.number in self._executed and not frame.is_cut_at_once):
            if not frame.is_cut_at_once:
                self.findings.violate(Rule.STRUCTURE, "its values are missing", span, *frame.records)
            return
        instance.node = owner
        if not frame.is_cut_at_once:
            self._executed.add(instance.number)
        is_inside = frame.start.seq < instance.seq
        t, due = instance.recorded["t"], frame.start
        if t != due.t if is_inside else not owner.start.t <= t <= due.t:
            message = f"it gets its values at {t:g} s, but starts at {due.t:g} s"
            self.findings.violate(Rule.VALUE, message, span, due.seq, instance.seq)
        if behavior is None and instance.number == owner.instances[0]:
            self.matched.invocations.append((None, instance, instance))
        self.matched.executions.append((instance, frame))
        others = self._reactions(instance, frame)
        body = instance.declaration.body if isinstance(instance.declaration, plan_.Scenario) else None
        frame = replace(frame, children=tuple(others))
        if body is not None:
            self._body(body, instance, frame)
            return
        for child in others:
            message = f"`{child.name}` is not part of `{instance.declaration.name}`"
            self.findings.violate(Rule.TREE, message, span, child.start.seq)
        if isinstance(instance.declaration, plan_.Scenario):
            self.check_end(frame, End(SUCCEEDED, frame.start.t), Rule.DIRECT, span)

    def _reactions(self, instance: Instance, frame: Frame) -> list[Node]:
        """Match the reactions of an instance; return the other behaviors."""
        late = late_reactions(instance, frame) if instance.declaration.on else ()
        others = [*frame.children, *(child for child in late if child not in frame.children)]
        for directive in instance.declaration.on:
            mine = [child for child in others if any(is_of(child, member) for member in directive.members)]
            others = [child for child in others if child not in mine]
            for node in mine:
                member = next(each for each in directive.members if is_of(node, each))
                self.matched.plans[node.number] = member
                self._zero_time(node, member)
            self.matched.reactions.append((instance, directive, tuple(mine)))
        return others

    def _body(self, body: plan_.Behavior, instance: Instance, frame: Frame) -> None:
        """Match the `do` of a scenario, which lasts as long, unless `emit end` or `emit fail` ends it before."""
        node = self._only_child(frame, Rule.DIRECT, "its `do`", body.span, lambda child: is_of(child, body))
        if node is None:
            return
        if not ends_by_emit(instance, frame):
            is_left = node.status == CANCELLED and not self.was_overridden(node)
            end = End(None, node.end.t) if is_left else self.end_of(node)
            self.check_end(frame, end, Rule.DIRECT, body.span)
        self._pending.append(partial(self._behavior, body, node, instance, frozenset({CANCELLED})))
