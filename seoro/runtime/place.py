"""Where a behavior is carried out: its flow, its scenario, its position; and what people call it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from seoro.lang.plan import (
    Behavior,
    CallMethod,
    Emit,
    InvokeAction,
    InvokeScenario,
    OneOf,
    Parallel,
    Serial,
    Wait,
)
from seoro.runtime.agenda import Agenda, Flow
from seoro.runtime.environment import Seed
from seoro.runtime.evaluate import Environment, HasFields
from seoro.runtime.instances import Instance, Invoked
from seoro.runtime.services import Services
from seoro.runtime.values import Value

if TYPE_CHECKING:
    pass


@dataclass(eq=False, slots=True)
class Place:
    """Where a behavior is carried out; never changed, but not frozen, since each behavior gets several.

    Args:
        services: Of the run.
        flow: The flow of control.
        instance: The scenario that contains it.
        parent: Number, in the trace, of the behavior around it.
        position: Its position in the tree of invocations.
        path: The same, for people.
        invoked: For what modifies an invocation or a composition, and for what carries it out: what that is.
        runs: How many times each modifier around it has started what it modifies.
    """

    services: Services
    flow: Flow
    instance: Instance
    parent: int | None
    position: tuple[int, ...]
    path: str
    invoked: Invoked | None = None
    runs: tuple[int, ...] = ()

    @property
    def purpose(self) -> str:
        """Names what is drawn here: the same in any order of steps, another in each repetition."""
        return f"{self.path} {'.'.join(map(str, self.runs)) if self.runs else ''}"

    def take_invoked(self) -> Instance:
        """What is carried out here by an invocation."""
        assert self.invoked is not None, "an invocation stands here"
        instance = self.invoked.take(self)
        assert isinstance(instance, Instance), "it is no composition"
        return instance

    @property
    def agenda(self) -> Agenda:
        """The agenda of the run."""
        return self.services.agenda

    def within(self, flow: Flow) -> Place:
        """The same, in a flow that was forked for it."""
        return Place(
            self.services, flow, self.instance, self.parent, self.position, self.path, self.invoked, self.runs
        )

    def member(self, index: int, behavior: Behavior) -> Place:
        """The place of a member of what stands here."""
        position, path = (*self.position, index), f"{self.path}/{name_of(behavior)}[{index}]"
        return Place(self.services, self.flow, self.instance, self.parent, position, path, self.invoked, self.runs)

    def invoking(self, invoked: Invoked | None) -> Place:
        """The same, where something is invoked."""
        return Place(
            self.services, self.flow, self.instance, self.parent, self.position, self.path, invoked, self.runs
        )

    def again(self, run: int) -> Place:
        """The same, in one of the runs of what a modifier there modifies; the first is 1."""
        path, runs = self.path if run == 1 else f"{self.path}#{run}", (*self.runs, run)
        return Place(self.services, self.flow, self.instance, self.parent, self.position, path, self.invoked, runs)

    def inside(self, number: int) -> Place:
        """The same, within the behavior that has a number in the trace."""
        return Place(
            self.services, self.flow, self.instance, number, self.position, self.path, self.invoked, self.runs
        )

    def environment(self, bindings: Mapping[str, Value | HasFields] | None = None) -> Environment:
        """What names stand for here; in what modifies an invocation, `it` is what is invoked."""
        all_bindings = self.instance.bindings
        if bindings:
            all_bindings = {**bindings, **all_bindings}
        if self.invoked is not None:
            all_bindings = {**all_bindings, "it": self.invoked.instance}
        instance, seed = self.instance, Seed(self.services.seed, self.purpose)
        return Environment(instance, all_bindings, self.path, instance.around, seed=seed, run=self.services.run)


_KINDS: Mapping[type[Behavior], str] = {
    Serial: "serial",
    Parallel: "parallel",
    OneOf: "one_of",
    Wait: "wait",
    Emit: "emit",
    CallMethod: "call",
    InvokeAction: "action",
    InvokeScenario: "scenario",
}


def type_of(behavior: Behavior) -> str:
    """The kind of a behavior, as the trace calls it."""
    return _KINDS[type(behavior)]


def name_of(behavior: Behavior) -> str:
    """What people call a behavior: its label, else what it invokes as the scenario writes it, else its kind."""
    if behavior.label:
        return behavior.label
    match behavior:
        case InvokeAction() | InvokeScenario():
            return invoked_name(behavior)
        case _:
            return type_of(behavior)


def invoked_name(invocation: InvokeAction | InvokeScenario) -> str:
    """What is invoked as the scenario writes it: on the actor that does it, not on the type that declares it."""
    name = invocation.action if isinstance(invocation, InvokeAction) else invocation.scenario
    if invocation.actor is None:
        return name
    actor, short = invocation.actor.span.text, name.rpartition(".")[2]
    return short if actor == short else f"{actor}.{short}"
