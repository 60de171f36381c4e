"""Check that every action of a plan can be carried out, before the run starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, get_args

from seoro.errors import UsageError
from seoro.lang.plan import Field, InvokeAction, Plan, invocations_in
from seoro.lang.source import Span
from seoro.runtime.contracts.backends import Observing, Selective
from seoro.runtime.execution.assignment import ActorAssignment, Contract, Home
from seoro.runtime.functions.actions import BoundAction
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.values import Actor

if TYPE_CHECKING:
    from seoro.runtime.functions.modifiers import BoundModifier


class MissingRobot(UsageError):
    """No backend of the run has a robot for an actor, or supports an action.

    Args:
        message: Description of the problem.
        span: The invocation.
        help: Possible fixes.
        actor: Name of the actor without a robot; empty if unknown before the run.
    """

    def __init__(self, message: str, span: Span, help: str, actor: str = "") -> None:  # noqa: A002
        super().__init__(message, span, help)
        self.actor = actor


def check_needs(plan: Plan, entry: Instance, actions: Mapping[str, BoundAction], homes: ActorAssignment) -> None:
    """Check every invocation of an action.

    Raises:
        UsageError: No backend, or not the backend of the actor, can carry out an action.
    """
    for scenario in plan.scenarios.values():
        for invocation in invocations_in(scenario.body):
            if not isinstance(invocation, InvokeAction):
                continue
            mark = actions[invocation.action].mark
            if mark.anywhere is not None and not homes.serve(mark.anywhere):
                raise _nobody(invocation, mark.anywhere, homes)
            if mark.home is None:
                continue
            actor = _known_actor(invocation, entry) if scenario is entry.declaration else None
            if actor is None:  # known at its invocation only
                if not homes.serve(mark.home):
                    raise _nobody(invocation, mark.home, homes)
                continue
            home = homes.of(actor)
            if home is None:
                raise _homeless(invocation, actor, mark.home, homes)
            _check_support(invocation, actor, mark.home, home)


def _check_support(invocation: InvokeAction, actor: Actor, contract: Contract, home: Home) -> None:
    """Check that the backend of an actor supports one of the parts of a contract for it."""
    backend, missing = home.backend, ""
    for part in get_args(contract) or (contract,):
        if isinstance(backend, part):
            missing = backend.reason_missing(part, home.name) if isinstance(backend, Selective) else ""
            if not missing:
                return
    reason = f"{backend.name}, the backend of `{actor.name}`, does not support `{invocation.action}`"
    hint = backend.reason_unobeyed() if isinstance(backend, Observing) else ""
    raise UsageError(f"{reason}: {missing}" if missing else reason, invocation.span, hint)


def _known_actor(invocation: InvokeAction, entry: Instance) -> Actor | None:
    if isinstance(invocation.actor, Field):
        value = entry.fields[invocation.actor.name]
        return value if isinstance(value, Actor) else None
    return None


def _nobody(invocation: InvokeAction, contract: Contract, homes: ActorAssignment, actor: str = "") -> MissingRobot:
    from seoro.runtime.contracts.ros2 import ObservedSystem, Ros2System  # noqa: PLC0415 - for this message only

    names = ", ".join(backend.name for backend in homes.backends)
    why = f"unsupported by {names}" if names else "the run has neither a simulator nor a robot"
    parts = get_args(contract) or (contract,)
    fixes = []
    in_ros = (ObservedSystem, Ros2System)
    if any(part not in in_ros for part in parts):
        fixes.append(
            "start a simulator with `--sim mujoco`, connect to a running one with `--connect`, or assign actors "
            "with `--lab`"
        )
    if any(part in in_ros for part in parts):
        fixes.append("reach a ROS 2 system with `--ros`, such as `--ros tcp/192.168.0.7:7447`")
    message = f"cannot carry out `{invocation.action}`: {why}"
    return MissingRobot(message, invocation.span, "; ".join(fixes), actor)


def _homeless(invocation: InvokeAction, actor: Actor, contract: Contract, homes: ActorAssignment) -> MissingRobot:
    if not homes.backends:
        return _nobody(invocation, contract, homes, actor.name)
    names = ", ".join(backend.name for backend in homes.backends)
    return MissingRobot(
        f"no robot for `{actor.name}` ({actor.type.name}): {names} has no suitable robot left",
        invocation.span,
        "choose a world with such a robot with `--world`, or assign the actor in a lab file",
        actor.name,
    )


def check_implementations(
    plan: Plan, actions: Mapping[str, BoundAction], modifiers: Mapping[str, BoundModifier]
) -> None:
    """Check that every action that can be invoked and every modifier that is applied has an implementation.

    Raises:
        UsageError: An implementation is missing.
    """
    for name, action in plan.actions.items():
        if name not in actions:
            from seoro.runtime.actions.substitutes import substitute  # noqa: PLC0415 - for this message only

            invoked = (each.span for each in plan.action_invocations() if each.action == name)
            raise UsageError(
                f"the action `{name}` has no implementation",
                next(invoked, action.span),
                substitute(name, action.library) if action.library else
                "implement it in Python, with `@seoro.action`, in a library",
            )  # fmt: skip
    for name, modifier in plan.modifiers.items():
        if modifier.library is not None and name not in modifiers:
            raise UsageError(
                f"the modifier `{name}` has no implementation",
                modifier.span,
                f"the library `{modifier.library}` only declares it",
            )
