"""Findings about executors and nodes alike: version, clock, latency."""

from __future__ import annotations

from typing import Final

from seoro import __version__
from seoro.bridges.executor.clocks import Clock
from seoro.doctor.findings import Finding, ok, warning

SLOW: Final = 0.1  # [s], noticeable round trip
RENEW: Final = "it is older than this seoro: update it"
RELEASE: Final = 'once it is safe: `seoro lab release --all --reason "..."`'


def version_finding(what: str, kind: str, theirs: tuple[str, str], protocol: str) -> Finding:
    """Compare the version of an executor or a node with this one.

    Args:
        what: Name of the executor or node.
        kind: Kind, such as `a bridge`; empty if it is known from its name.
        theirs: Version of its seoro and of its protocol.
        protocol: Version of the protocol here.
    """
    version, spoken = theirs
    text = f"{kind}seoro {version}, protocol {spoken}"
    if theirs == (__version__, protocol):
        return ok(what, f"{text}, same as here")
    return warning(what, f"{text}, but here {__version__} with {protocol}", "use the same version on both sides")


def clock_finding(what: str, clock: Clock | None) -> Finding:
    """Compare a clock with that of this machine."""
    if clock is None:
        return warning(what, "does not report its clock", RENEW)
    if clock.is_wrong:
        return warning(what, f"its clock is {clock}", "synchronise both machines by NTP")
    return ok(what, f"its clock is {clock}, give or take {1000.0 * clock.round_trip / 2.0:.1f} ms")


def latency_finding(what: str, half: float, most: float, exchanges: int) -> Finding:
    """Report the latency of answers: median and 99th percentile [s]."""
    text = f"latency {1000.0 * half:.1f} ms (p50), {1000.0 * most:.1f} ms (p99 of {exchanges})"
    return ok(what, text) if most < SLOW else warning(what, text, "the network or the machine is slow or busy")
