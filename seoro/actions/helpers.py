"""`osc.helpers`: actions, modifiers, and methods of the struct `common`."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from enum import Enum
from typing import Any

from seoro.actions.messages import log
from seoro.errors import ActionFailed, UsageError
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.modifiers import Child, ModifierContext
from seoro.runtime.functions.actions import action
from seoro.runtime.functions.modifiers import modifier
from seoro.runtime.values.comparison import RELATIONS, NotComparable, compare_values
from seoro.runtime.values.conversions import wrapped
from seoro.runtime.values.environment import MethodContext
from seoro.runtime.values.values import Variable
from seoro.runtime.verdict import SUCCEEDED, Outcome, Status

__all__ = ["log"]  # re-exported: part of the library


@action("increment")
async def increment(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Add one to a numeric variable."""
    ctx.update(target_variable, lambda value: wrapped(value + 1, target_variable.type))


@action("decrement")
async def decrement(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Subtract one from a numeric variable."""
    ctx.update(target_variable, lambda value: wrapped(value - 1, target_variable.type))


@action("compare")
async def compare(ctx: ActionContext, left_value: Any, operator: str, right_value: Any) -> None:
    """Compare two values by `==`, `!=`, `<`, `<=`, `>` or `>=`; fail if the comparison is false."""
    if operator not in RELATIONS:
        raise ActionFailed(f"unknown operator `{operator}`; expected one of {', '.join(RELATIONS)}")
    left, right = ctx.text_of("left_value", left_value), ctx.text_of("right_value", right_value)
    types = ctx.type_of("left_value"), ctx.type_of("right_value")
    try:
        is_true = compare_values(left_value, types[0], operator, right_value, types[1])
    except NotComparable:
        raise ActionFailed(
            f"cannot compare `{left}` and `{right}` by `{operator}`: the types differ or have no order"
        ) from None
    if _is_number(left_value) and _is_number(right_value):
        distance = _distance(left_value, operator, right_value)
        if operator != "==" or distance:  # equality has no distance to fail
            ctx.record_margin(distance, right_value)
    if not is_true:
        raise ActionFailed(f"`{left} {operator} {right}` is false")


def _distance(left: float, operator: str, right: float) -> float:
    """Return the distance of the left value to the limit of a comparison, negative beyond it."""
    match operator:
        case "==":
            return -abs(left - right)
        case "!=":
            return abs(left - right)
        case "<" | "<=":
            return right - left
        case _:
            return left - right


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


# ---------------------------------------------------------------- processes


class Signal(Enum):
    """The enumeration `signal`."""

    sighup = signal.SIGHUP
    sigint = signal.SIGINT
    sigkill = signal.SIGKILL
    sigusr1 = signal.SIGUSR1
    sigusr2 = signal.SIGUSR2
    sigterm = signal.SIGTERM


@action("run_process")
async def run_process(
    ctx: ActionContext, command: str, wait_for_shutdown: bool, shutdown_signal: Signal, shutdown_timeout: float
) -> None:
    """Run a program in the working directory; wait for its end, or only for its start."""
    if shutdown_timeout < 0:
        raise ActionFailed(f"invalid `shutdown_timeout`: expected at least 0 s, found {shutdown_timeout:g} s")
    from seoro.actions.processes import Ending, run_program, split_command  # noqa: PLC0415 - with anyio

    ending = Ending(shutdown_signal.value, shutdown_timeout)
    await run_program(ctx, split_command(command), ending, wait=wait_for_shutdown)


@action("process_log_check")
async def process_log_check(
    ctx: ActionContext, process_name: str, values: Sequence[str], from_start: bool
) -> None:
    """Wait until the process of a label writes a line that contains any of the texts."""
    if not values:
        raise ActionFailed("`values` is empty; expected at least one text")
    from seoro.actions.processes import RUNNING_PROGRAMS, Processes  # noqa: PLC0415 - with anyio

    labels = ctx.labels_of(RUNNING_PROGRAMS)
    if process_name not in labels:
        others = f" (labels of programs: {', '.join(sorted(labels))})" if labels else ""
        raise ActionFailed(f"unknown process `{process_name}`{others}; expected the label of a started program")
    processes = ctx.shared(Processes)
    await ctx.sleep(0.0)  # starts of the same delta cycle count, in any order of members
    while (process := processes.find(process_name)) is None:
        await ctx.wait_for(processes.start)
    line = await process.find(values, from_start=from_start)
    if line is None:
        wanted = " or ".join(f"'{value}'" for value in values)
        raise ActionFailed(f"`{process_name}` {await process.end_of_output()} without {wanted} in its output")


# ---------------------------------------------------------------- modifiers


@modifier("repeat")
async def repeat(ctx: ModifierContext, child: Child, count: int) -> Outcome:
    """Repeat the behavior while it succeeds, `count` times in total; -1 for no limit."""
    if count < 1 and count != -1:
        raise ActionFailed(f"invalid `count`: expected at least 1, or -1 for no limit, found {count}")
    runs = 0
    while True:
        outcome = await _run(child)
        runs += 1
        if outcome.failed or runs == count:
            return outcome


@modifier("retry")
async def retry(ctx: ModifierContext, child: Child, count: int) -> Outcome:
    """Repeat the behavior while it fails, `count` times in total."""
    if count < 1:
        raise ActionFailed(f"invalid `count`: expected at least 1, found {count}")
    for _ in range(count):
        outcome = await _run(child)
        if not outcome.failed:
            break
    return outcome


@modifier("timeout")
async def timeout(ctx: ModifierContext, child: Child, duration: float) -> Outcome:
    """Cancel the behavior after a duration [s] and fail."""
    if duration < 0:
        raise ActionFailed(f"invalid `duration`: expected at least 0 s, found {duration:g} s")
    begun = ctx.now
    outcome = await child.run(limit=duration)
    ctx.record_margin(0.0 if outcome is None else duration - (ctx.now - begun), duration)
    return Outcome(Status.FAILED, f"timeout: still running after {duration:g} s") if outcome is None else outcome


@modifier("inverter")
async def inverter(ctx: ModifierContext, child: Child) -> Outcome:
    """Swap success and failure."""
    outcome = await _run(child)
    return SUCCEEDED if outcome.failed else _FAILED_BY_SUCCESS


@modifier("failure_is_success")
async def failure_is_success(ctx: ModifierContext, child: Child) -> Outcome:
    """Turn failure into success."""
    await _run(child)
    return SUCCEEDED


@modifier("success_is_failure")
async def success_is_failure(ctx: ModifierContext, child: Child) -> Outcome:
    """Turn success into failure."""
    outcome = await _run(child)
    return outcome if outcome.failed else _FAILED_BY_SUCCESS


@modifier("success_is_running")
async def success_is_running(ctx: ModifierContext, child: Child) -> Outcome:
    """Keep running after success, until cancelled."""
    outcome = await _run(child)
    return outcome if outcome.failed else await ctx.hold()


@modifier("failure_is_running")
async def failure_is_running(ctx: ModifierContext, child: Child) -> Outcome:
    """Keep running after failure, until cancelled."""
    outcome = await _run(child)
    return outcome if not outcome.failed else await ctx.hold()


@modifier("running_is_failure")
async def running_is_failure(ctx: ModifierContext, child: Child) -> Outcome:
    """Cancel the behavior and fail, unless it ends in the instant in which it starts."""
    outcome = await child.run(limit=0.0)
    return Outcome(Status.FAILED, "still running after its first instant") if outcome is None else outcome


@modifier("running_is_success")
async def running_is_success(ctx: ModifierContext, child: Child) -> Outcome:
    """Cancel the behavior and succeed, unless it ends in the instant in which it starts."""
    outcome = await child.run(limit=0.0)
    return SUCCEEDED if outcome is None else outcome


async def _run(child: Child) -> Outcome:
    """Run the behavior to its end."""
    outcome = await child.run()
    assert outcome is not None, "it has no limit"
    return outcome


_FAILED_BY_SUCCESS = Outcome(Status.FAILED, "the behavior succeeded")


# ---------------------------------------------------------------- methods


def get_scenario_file_directory(run: MethodContext) -> str:
    """Return the folder of the scenario file, as an absolute path."""
    return str(run.resolve_path(run.file.name).resolve().parent)


def get_output_directory(run: MethodContext) -> str:
    """Return the output folder of the run, as an absolute path.

    Raises:
        UsageError: The run has no output folder.
    """
    if run.output_directory is None:
        raise UsageError("the run has no output folder; choose one with `-o`")
    return str(run.output_directory.resolve())
