"""Requests to members of a lab, and their outcomes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import anyio

from seoro.bridges import wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.session import SessionError, is_secured
from seoro.bridges.sim.requests import ask
from seoro.errors import BackendError, BackendRefused, UsageError
from seoro.lab.status import Connection

STOP_TIMEOUT = 2.0  # [s] time limit for a node to acknowledge a stop


@dataclass(frozen=True)
class Outcome:
    """Result of a request to a node or an executor.

    Attributes:
        endpoint: Endpoint of the request.
        display_name: Name of the node or executor in messages.
        done: Completed action, as text.
        error: Reason of the failure; empty on success.
        elapsed: Time from the start of the emergency stop to the answer [s]; infinite for other requests.
        is_reached: Whether a node or an executor was reached.
        stopped: Robots or runs stopped by an emergency stop.
        is_elsewhere: Whether a node has none of the named robots.
    """

    endpoint: str
    display_name: str
    done: str = ""
    error: str = ""
    elapsed: float = math.inf
    is_reached: bool = True
    stopped: tuple[str, ...] = ()
    is_elsewhere: bool = False


OnOutcome: TypeAlias = Callable[[Outcome], object]


def ignore_outcome(_outcome: Outcome) -> None:
    """Do nothing with an outcome."""


async def request_outcome(
    each: Connection, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, began: float = math.inf
) -> Outcome:
    """Send a request to a member; failures are outcomes, too.

    Args:
        each: Connection to the member.
        verb: Verb of the request.
        request: The request.
        began: Start of an emergency stop, by the monotonic clock [s].
    """
    member, session = each.member, each.session
    outcome = Outcome(member.endpoint, member.display_name)
    if session is None or not member.node:
        return replace(outcome, error=member.problem, is_reached=False)
    try:
        if member.is_executor:
            secured = is_secured(member.endpoint)
            executor = Executor(session, member.node, minor=0, keys=each.keys, is_secured=secured)
            with anyio.fail_after(STOP_TIMEOUT):
                answer = await executor.ask(verb, request)
        else:
            answer = await ask(each.address(session), verb, request, STOP_TIMEOUT)
    except TimeoutError:
        return replace(outcome, error=f"no answer within {STOP_TIMEOUT:g} s")
    except BackendRefused as error:
        is_elsewhere = isinstance(request, wire.EmergencyStop) and error.code == wire.Result.NOT_FOUND
        return replace(outcome, error=str(error), is_elsewhere=is_elsewhere)
    except (BackendError, UsageError, SessionError) as error:
        return replace(outcome, error=str(error))
    outcome = replace(outcome, elapsed=time.monotonic() - began)
    if not isinstance(answer, wire.StopAcknowledgement):
        done = {wire.LEASE_ROBOTS.name: "leased", wire.STOP_ROBOT.name: "stopped"}.get(verb.name, "released")
        return replace(outcome, done=done)
    what = "runs" if member.is_executor else "robots"
    done = f"stopped {', '.join(answer.stopped)}" if answer.stopped else f"stopped; it has no {what}"
    if answer.unsettled:
        doubt = f"{done}; goals of {', '.join(answer.unsettled)} have not ended, and may continue"
        return replace(outcome, error=doubt, stopped=answer.stopped)
    return replace(outcome, done=done, stopped=answer.stopped)
