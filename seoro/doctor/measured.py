"""What is said of executors and nodes alike: version, clock, latency, an emergency stop."""

from __future__ import annotations

from typing import Final

from seoro import __version__
from seoro.bridges.executor.clocks import Clock
from seoro.doctor.findings import Finding, ok, warning

SLOW: Final = 0.1  # [s] of a round trip that people notice
RENEW: Final = "it is older than this seoro: renew it"
RELEASE: Final = '`seoro lab release --all --reason "why it is safe"` ends that, once it is'


def tell_version(what: str, kind: str, theirs: tuple[str, str], protocol: str) -> Finding:
    """Whether somebody is of our version.

    Args:
        what: Who.
        kind: What it is, such as `a bridge`; empty if its name says so.
        theirs: Its version, and that of the protocol that it speaks.
        protocol: That which this seoro speaks.
    """
    version, spoken = theirs
    said = f"is {kind}of seoro {version} and speaks version {spoken} of the protocol"
    if theirs == (__version__, protocol):
        return ok(what, f"{said}, as this does")
    return warning(
        what, f"{said}, and this is {__version__} with {protocol}", "use the same version on both sides"
    )


def tell_clock(what: str, clock: Clock | None) -> Finding:
    """How far a clock is from ours."""
    if clock is None:
        return warning(what, "does not tell its clock", RENEW)
    if clock.is_wrong:
        return warning(what, f"its clock is {clock}", "have both machines set their clocks by NTP")
    return ok(what, f"its clock is {clock}, give or take {1000.0 * clock.round_trip / 2.0:.1f} ms")


def tell_latency(what: str, half: float, most: float, exchanges: int) -> Finding:
    """How long answers take: half of them, and 99 % [s]."""
    text = f"answers in {1000.0 * half:.1f} ms (p50), {1000.0 * most:.1f} ms (p99 of {exchanges})"
    return ok(what, text) if most < SLOW else warning(what, text, "the network or the machine is slow or busy")
