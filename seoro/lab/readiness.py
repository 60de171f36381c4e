"""Whether a robot is ready for a run: what the lab asks for before one, and whether somebody has it."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.errors import InvalidUse
from seoro.lab.reading import Lab
from seoro.lab.schema import BeforeFile


def hindrances(before: BeforeFile, state: wire.RobotState | str, lease: str) -> tuple[list[str], list[str]]:
    """What keeps a robot from being had.

    Args:
        before: What has to be so.
        state: How it is; or why that cannot be known.
        lease: Id of the lease by hand that the run has.

    Returns:
        What is not as it has to be, and who has it, both in words.
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
    return unready(before, state), occupied


def unready(before: BeforeFile, state: wire.RobotState) -> list[str]:
    """What of a robot is not as it has to be before a run, in words."""
    found = []
    if before.battery is not None:
        if state.battery is None:
            found.append("the charge of its battery is not known")
        elif state.battery < before.battery:
            found.append(f"its battery is at {state.battery:.0%}, below {before.battery:.0%}")
    if before.localised and not state.localised:
        found.append("it does not know where it is")
    if before.area is not None:
        if state.position is None:
            found.append("where it is cannot be known")
        elif not before.area.has(*state.position):
            x, y = state.position
            found.append(f"it is at x {x:.2f} m, y {y:.2f} m, and has to be in {before.area}")
    return found


def needs_state(before: BeforeFile) -> bool:
    """Whether something has to be so before a run."""
    return before != BeforeFile()


def check_ready(lab: Lab, name: str, state: wire.RobotState) -> None:
    """Refuse a run with a robot that is not as the lab asks for.

    Raises:
        InvalidUse: It is not; lists everything.
    """
    found = unready(lab.robots[name].before, state)
    if found:
        raise InvalidUse(f"{lab.place(name)}: robots.{name} is not ready: {'; '.join(found)}")
