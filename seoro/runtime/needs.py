"""Whether every action of a plan can be carried out, checked when a run is instantiated, before anything moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from seoro.errors import InvalidUse
from seoro.lang.plan import Field, InvokeAction, Plan
from seoro.lang.source import Span
from seoro.runtime.actions import BoundAction
from seoro.runtime.homes import Contract, Homes
from seoro.runtime.instances import Instance
from seoro.runtime.invocations import invocations_in
from seoro.runtime.ros_system import Ros2System
from seoro.runtime.values import Actor


class NoHome(InvalidUse):
    """No backend of the run has a robot for an actor, or for what an action needs.

    Args:
        message: What is wrong.
        span: The invocation.
        help: What would work.
        actor: Name of the actor that has no robot; empty if it is not known before the run.
    """

    def __init__(self, message: str, span: Span, help: str, actor: str = "") -> None:  # noqa: A002
        super().__init__(message, span, help)
        self.actor = actor


def check_needs(plan: Plan, entry: Instance, actions: Mapping[str, BoundAction], homes: Homes) -> None:
    """Check every invocation of an action.

    Raises:
        InvalidUse: The home of an actor cannot carry out an action, or nothing can.
    """
    for scenario in plan.scenarios.values():
        for invocation in invocations_in(scenario.body):
            mark = actions[invocation.action].mark
            if mark.anywhere is not None and not homes.serve(mark.anywhere):
                raise _nobody(invocation, mark.anywhere, homes)
            if mark.home is None:
                continue
            actor = _known_actor(invocation, entry) if scenario is entry.declaration else None
            if actor is None:  # only known when it is invoked
                if not homes.serve(mark.home):
                    raise _nobody(invocation, mark.home, homes)
                continue
            home = homes.of(actor)
            if home is None:
                raise _homeless(invocation, actor, mark.home, homes)
            if not isinstance(home.backend, mark.home):
                raise InvalidUse(
                    f"`{actor.name}` lives in {home.backend.name}, which cannot carry out `{invocation.action}`",
                    invocation.span,
                )


def _known_actor(invocation: InvokeAction, entry: Instance) -> Actor | None:
    if isinstance(invocation.actor, Field):
        value = entry.fields[invocation.actor.name]
        return value if isinstance(value, Actor) else None
    return None


def _nobody(invocation: InvokeAction, contract: Contract, homes: Homes, actor: str = "") -> NoHome:
    names = ", ".join(backend.name for backend in homes.backends)
    why = f"{names} cannot carry it out" if names else "there is neither a simulator nor a robot"
    parts = get_args(contract) or (contract,)
    ways = []
    if any(part is not Ros2System for part in parts):
        ways.append(
            "start a simulator for the run with `--sim mujoco`, connect to one with `--connect`, or say with "
            "`--lab` where actors live"
        )
    if Ros2System in parts:
        ways.append("reach a ROS 2 system with `--ros`, such as `--ros tcp/192.168.0.7:7447`")
    return NoHome(f"`{invocation.action}` cannot be carried out: {why}", invocation.span, "; ".join(ways), actor)


def _homeless(invocation: InvokeAction, actor: Actor, contract: Contract, homes: Homes) -> NoHome:
    if not homes.backends:
        return _nobody(invocation, contract, homes, actor.name)
    names = ", ".join(backend.name for backend in homes.backends)
    return NoHome(
        f"`{actor.name}` ({actor.type.name}) lives nowhere: no robot of {names} is left that can stand for it",
        invocation.span,
        "choose a world with such a robot with `--world`, or say in a lab file where it lives",
        actor.name,
    )
