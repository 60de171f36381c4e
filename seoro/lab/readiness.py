"""Readiness of a robot for a run: conditions of the lab file, and holders and leases."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.lab.schema import BeforeFile


def conflicts(before: BeforeFile, state: wire.RobotState | str, lease: str) -> tuple[list[str], list[str]]:
    """Return the reasons why a robot cannot be acquired.

    Args:
        before: Conditions before a run.
        state: State of the robot, or the reason if it is unknown.
        lease: Id of the manual lease of the run.

    Returns:
        Unmet conditions, and holders of the robot, as text.
    """
    if isinstance(state, str):
        return [state], []
    occupied = []
    if state.holder:
        occupied.append(f"held by {state.holder}")
    if state.lease is not None and state.lease.lease != lease:
        occupied.append(f"leased ({state.lease.purpose or state.lease.lease})")
    if not state.holder and state.waiting:
        occupied.append(f"{state.waiting[0]} waits for it")
    return unmet_conditions(before, state), occupied


def unmet_conditions(before: BeforeFile, state: wire.RobotState) -> list[str]:
    """Return the conditions that a robot does not meet before a run, as text."""
    found = []
    if before.battery is not None:
        if state.battery is None:
            found.append("the charge of its battery is unknown")
        elif state.battery < before.battery:
            found.append(f"its battery is at {state.battery:.0%}, below {before.battery:.0%}")
    if before.localised and not state.localised:
        found.append("it is not localised")
    if before.area is not None:
        if state.position is None:
            found.append("its position is unknown")
        elif not before.area.contains(*state.position):
            x, y = state.position
            found.append(f"it is at x {x:.2f} m, y {y:.2f} m, outside of {before.area}")
    return found
