"""Probes of the endpoints of a lab: which nodes answer there, and how fast.

Scenarios run on executors, which may reach other nodes than their clients. So executors probe on request.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Final

from pydantic import Field

from seoro.bridges.executor.messages import ExecutorMessage, Text
from seoro.bridges.wire.lab import LabState, RobotCheck
from seoro.bridges.wire.message import Verb

MAX_PLACES: Final = 32
PROBE_TIMEOUT: Final = 30.0  # [s] time limit of an executor


class Hop(StrEnum):
    """Hop at which the path to an endpoint is broken."""

    POLICY = "policy"  # of the probing executor
    KEYS = "keys"
    SESSION = "session"


class NodeReport(ExecutorMessage):
    """Report about a node: a simulator or a bridge.

    Attributes:
        node: Name of the node.
        count: Number of nodes with that name.
        major: Version of its protocol.
        why: Reason why it cannot be queried; empty if it can.
        state: State of its robots.
        is_usable: Whether the prober may use its robots; None if the role of its keys does not allow that.
        why_not: Reason why it may not.
        offset: Time by which its clock is ahead [s]; None if the node does not report its clock.
        doubt: Uncertainty of `offset` [s].
        half: Median latency [s].
        most: 99th percentile of the latency [s].
        exchanges: Number of measured exchanges.
        checks: Checks of its robots, by their names; none of simulators.
    """

    node: str
    count: int = 1
    major: str = ""
    why: str = ""
    state: LabState | None = None
    is_usable: bool | None = None
    why_not: str = ""
    offset: float | None = None
    doubt: float = 0.0
    half: float = 0.0
    most: float = 0.0
    exchanges: int = 0
    checks: dict[str, RobotCheck] = Field(default_factory=dict)


class EndpointReport(ExecutorMessage):
    """Report about an endpoint.

    Attributes:
        endpoint: The endpoint.
        who: Name and role of the prober; empty without keys.
        ends_at: Hop at which the path is broken; None if the endpoint is reached.
        why: Reason of the break.
        advice: Suggestion for a fix.
        nodes: The nodes there.
    """

    endpoint: str
    who: str = ""
    ends_at: Hop | None = None
    why: str = ""
    advice: str = ""
    nodes: tuple[NodeReport, ...] = ()


class ProbeRequest(ExecutorMessage):
    """Request to an executor to probe endpoints.

    Attributes:
        role: Role of the client; an executor with keys sets it.
    """

    endpoints: Annotated[tuple[Text, ...], Field(min_length=1, max_length=MAX_PLACES)]
    role: Text = ""


class ProbeReport(ExecutorMessage):
    """Reports about the endpoints of a request, in the same order."""

    places: tuple[EndpointReport, ...]


PROBE: Final = Verb("look", ProbeRequest, ProbeReport, is_audited=True)
