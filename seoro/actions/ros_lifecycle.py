"""The action of `osc.ros` that watches the lifecycle of a node."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import as_action_failure, log_missing, observed_system
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import ObservedSystem
from seoro.runtime.functions.actions import action

GONE, FINAL = "gone", "finalized"  # a node may disappear after its last state


@action("assert_lifecycle_state", anywhere=ObservedSystem, open_ended=True)
async def assert_lifecycle_state(
    ctx: ActionContext,
    node_name: str,
    state_sequence: Sequence[EnumValue],
    allow_initial_skip: bool,
    fail_on_unexpected: bool,
    keep_running: bool,
) -> None:
    """Watch a node pass through a sequence of states, starting at its present state; it may stay in the last.

    With `keep_running` the action continues after the last state; otherwise it ends there.
    """
    sequence = [state.member for state in state_sequence]
    if not sequence:
        raise ActionFailed("`state_sequence` is empty; expected at least one state")
    place = -1  # index of the last state reached
    with as_action_failure(), log_missing(ctx, lambda: _missing(node_name, sequence, place)):
        async with observed_system(ctx).lifecycle(node_name) as states:
            while True:
                state = await meanwhile(ctx, anext(states))
                found = _place(state, sequence, place, may_skip=allow_initial_skip)
                if found is not None:
                    place = found
                elif fail_on_unexpected and not (state == GONE and sequence[: place + 1][-1:] == [FINAL]):
                    raise ActionFailed(f"{node_name} is {state}; expected {_expected(sequence, place)}")
                if place == len(sequence) - 1 and not keep_running:
                    return


def _place(state: str, sequence: Sequence[str], place: int, *, may_skip: bool) -> int | None:
    """Return the index of a new state in the sequence; None if it is unexpected."""
    if place < 0 and may_skip and state in sequence:
        return sequence.index(state)
    following = sequence[place + 1 : place + 2]
    return place + 1 if [state] == following else None


def _expected(sequence: Sequence[str], place: int) -> str:
    if place + 1 < len(sequence):
        return f"{sequence[place + 1]}{f' after {sequence[place]}' if place >= 0 else ''}"
    return f"to stay {sequence[-1]}"


def _missing(node: str, sequence: Sequence[str], place: int) -> str:
    rest = sequence[place + 1 :]
    return f"{node} being {', then '.join(rest)}" if rest else ""
