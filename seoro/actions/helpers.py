"""`osc.helpers`: actions, modifiers, and the methods of its struct `common`."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from enum import Enum
from typing import Any

from seoro.actions.processes import RUNNING_PROGRAMS, Ending, Processes, run_program, split_command
from seoro.errors import ActionFailed, InvalidUse
from seoro.lang.integers import wrap_int, wrap_uint
from seoro.lang.plan import PrimitiveType, ValueType
from seoro.runtime.actions import action
from seoro.runtime.comparing import RELATIONS, NotComparable, compare_values
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Child, ModifierContext
from seoro.runtime.method_context import MethodContext
from seoro.runtime.modifiers import modifier
from seoro.runtime.values import Variable
from seoro.runtime.verdict import SUCCEEDED, Outcome, Status


@action("log")
async def log(ctx: ActionContext, msg: Any) -> None:
    """Write a message into the trace; values that are no strings are written as the language writes them."""
    ctx.log(ctx.text_of("msg", msg))


@action("increment")
async def increment(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Add one to a variable that holds a number."""
    ctx.update(target_variable, lambda value: _kept(value + 1, target_variable.type))


@action("decrement")
async def decrement(ctx: ActionContext, target_variable: Variable[float]) -> None:
    """Subtract one from a variable that holds a number."""
    ctx.update(target_variable, lambda value: _kept(value - 1, target_variable.type))


def _kept(value: float, type_: ValueType) -> float:
    """A number as a variable of a type holds it: whole ones have 64 bits."""
    if not isinstance(value, int):
        return value
    return wrap_uint(value) if type_ == PrimitiveType("uint") else wrap_int(value)


@action("compare")
async def compare(ctx: ActionContext, left_value: Any, operator: str, right_value: Any) -> None:
    """Compare two values by `==`, `!=`, `<`, `<=`, `>` or `>=`; it fails if that is not true of them."""
    if operator not in RELATIONS:
        raise ActionFailed(f"unknown operator `{operator}`; expected one of {', '.join(RELATIONS)}")
    left, right = ctx.text_of("left_value", left_value), ctx.text_of("right_value", right_value)
    types = ctx.type_of("left_value"), ctx.type_of("right_value")
    try:
        is_true = compare_values(left_value, types[0], operator, right_value, types[1])
    except NotComparable:
        raise ActionFailed(
            f"`{operator}` cannot compare `{left}` and `{right}`: they are of different types, or have no order"
        ) from None
    if not is_true:
        raise ActionFailed(f"`{left} {operator} {right}` is not true")


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
    """Run a program, in the working directory, and wait for its end or only until it runs."""
    if shutdown_timeout < 0:
        raise ActionFailed(f"`shutdown_timeout` cannot be negative, it is {shutdown_timeout:g} s")
    ending = Ending(shutdown_signal.value, shutdown_timeout)
    await run_program(ctx, split_command(command), ending, wait=wait_for_shutdown)


@action("process_log_check")
async def process_log_check(
    ctx: ActionContext, process_name: str, values: Sequence[str], from_start: bool
) -> None:
    """Wait until the process of that label writes a line with any of some texts in it."""
    if not values:
        raise ActionFailed("`values` is empty: there is nothing to look for")
    labels = ctx.labels_of(RUNNING_PROGRAMS)
    if process_name not in labels:
        others = f"; there is {', '.join(sorted(labels))}" if labels else ""
        raise ActionFailed(f"no program has the label `{process_name}`{others}")
    processes = ctx.shared(Processes)
    await ctx.sleep(0.0)  # then what starts in the same round counts as begun, in any order of members
    while (process := processes.find(process_name)) is None:
        await ctx.wait_for(processes.start)
    line = await process.find(values, from_start=from_start)
    if line is None:
        wanted = " or ".join(f"'{value}'" for value in values)
        raise ActionFailed(f"`{process_name}` {await process.end_of_output()} without {wanted} in its output")


# ---------------------------------------------------------------- modifiers


@modifier("repeat")
async def repeat(ctx: ModifierContext, child: Child, count: int) -> Outcome:
    """Run it again while it succeeds, `count` times altogether; with -1, for ever."""
    if count < 1 and count != -1:
        raise ActionFailed(f"a count of {count}: it has to be at least 1, or -1 for any number of times")
    runs = 0
    while True:
        outcome = await _run(child)
        runs += 1
        if outcome.failed or runs == count:
            return outcome


@modifier("retry")
async def retry(ctx: ModifierContext, child: Child, count: int) -> Outcome:
    """Run it again while it fails, `count` times altogether."""
    if count < 1:
        raise ActionFailed(f"a count of {count}: it has to be at least 1")
    for _ in range(count):
        outcome = await _run(child)
        if not outcome.failed:
            break
    return outcome


@modifier("timeout")
async def timeout(ctx: ModifierContext, child: Child, duration: float) -> Outcome:
    """Cancel it after a duration [s]; that is a failure."""
    if duration < 0:
        raise ActionFailed(f"a duration of {duration:g} s: it has to be at least 0 s")
    outcome = await child.run(limit=duration)
    return Outcome(Status.FAILED, f"timeout: still running after {duration:g} s") if outcome is None else outcome


@modifier("inverter")
async def inverter(ctx: ModifierContext, child: Child) -> Outcome:
    """Swap success and failure."""
    outcome = await _run(child)
    return SUCCEEDED if outcome.failed else _FAILED_BY_SUCCESS


@modifier("failure_is_success")
async def failure_is_success(ctx: ModifierContext, child: Child) -> Outcome:
    """Succeed in either case."""
    await _run(child)
    return SUCCEEDED


@modifier("success_is_failure")
async def success_is_failure(ctx: ModifierContext, child: Child) -> Outcome:
    """Fail in either case."""
    outcome = await _run(child)
    return outcome if outcome.failed else _FAILED_BY_SUCCESS


@modifier("success_is_running")
async def success_is_running(ctx: ModifierContext, child: Child) -> Outcome:
    """Hold after success, until it is cancelled."""
    outcome = await _run(child)
    return outcome if outcome.failed else await ctx.hold()


@modifier("failure_is_running")
async def failure_is_running(ctx: ModifierContext, child: Child) -> Outcome:
    """Hold after failure, until it is cancelled."""
    outcome = await _run(child)
    return outcome if not outcome.failed else await ctx.hold()


@modifier("running_is_failure")
async def running_is_failure(ctx: ModifierContext, child: Child) -> Outcome:
    """Cancel it if it does not end in the instant in which it starts; that is a failure."""
    outcome = await child.run(limit=0.0)
    return Outcome(Status.FAILED, "it has not ended at once") if outcome is None else outcome


@modifier("running_is_success")
async def running_is_success(ctx: ModifierContext, child: Child) -> Outcome:
    """Cancel it if it does not end in the instant in which it starts; that is a success."""
    outcome = await child.run(limit=0.0)
    return SUCCEEDED if outcome is None else outcome


async def _run(child: Child) -> Outcome:
    """Run it to its end."""
    outcome = await child.run()
    assert outcome is not None, "it has no limit"
    return outcome


_FAILED_BY_SUCCESS = Outcome(Status.FAILED, "it succeeded")


# ---------------------------------------------------------------- methods


def get_scenario_file_directory(run: MethodContext) -> str:
    """The folder of the scenario file, as an absolute path."""
    return str(run.place_of(run.file.name).resolve().parent)


def get_output_directory(run: MethodContext) -> str:
    """The folder for the results of the run, as an absolute path.

    Raises:
        InvalidUse: The run has none.
    """
    if run.output_directory is None:
        raise InvalidUse("the run has no output directory; give it one with `-o`")
    return str(run.output_directory.resolve())
