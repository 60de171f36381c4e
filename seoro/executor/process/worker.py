"""Process of a run, forked by `fork_server.py`.

It receives its job, executes it like a program that embeds seoro, reports the run, and ends. If the pipe for its
job closes, the executor has died: the run is stopped and cleans up, and the process is ended after a time.
"""

from __future__ import annotations

import asyncio
import io
import os
import socket
import sys
import traceback
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Final

import anyio

# Loaded before the fork, since most runs use a simulator.
import seoro.bridges.launch
import seoro.bridges.wire.all_messages  # noqa: F401
from seoro.bridges import wire
from seoro.bridges.executor.messages import BUNDLE, BundledFilm, DryRunResult
from seoro.bridges.session import brokered
from seoro.bundle.unpack import limit_of
from seoro.concurrency.background import background
from seoro.embed import announcement, prepare
from seoro.embed.picture_server import serving_pictures
from seoro.embed.run_end import End, Ended, ResultFile, not_started, pack_end
from seoro.embed.runs import Run
from seoro.embed.video import DESCRIPTION, NAME, Recording, VideoOptions
from seoro.errors import BackendError, InvalidScenario, UsageError, cause_of
from seoro.executor.job import Job
from seoro.executor.process.campaign import make_runs
from seoro.executor.process.control import AFTER_STOP, Control
from seoro.executor.process.emitter import Emitter
from seoro.executor.process.environment import enter
from seoro.executor.process.frames import NOT_BEGUN, Frame, read_frame
from seoro.executor.process.loading import load_run
from seoro.executor.process.trace_pipe import TracePipe
from seoro.executor.sandbox import broker
from seoro.executor.sandbox import command as sandbox
from seoro.executor.sandbox.enter import end_as
from seoro.executor.sandbox.enter import enter as enter_sandbox
from seoro.executor.sandbox.kernel_limits import limit_by_kernel, limit_tasks
from seoro.runtime.explain.reasons import fault_text
from seoro.runtime.trace.jsonl import to_json
from seoro.security.keys import VARIABLE as KEYS

UNHURRIED: Final = 19  # niceness of runs on the virtual clock, which cannot be late
SWITCH: Final = 0.0002  # [s] thread switch interval of the interpreter


class StoppedBefore(Exception):
    """The run was stopped before it began."""


def work(control_pipe: int, data_pipe: int) -> None:
    """Receive a job, execute it, and end the process.

    Args:
        control_pipe: Open descriptor of the pipe for the job.
        data_pipe: Open descriptor of the pipe for reports.
    """
    control = os.fdopen(control_pipe, "rb")
    first = read_frame(control)
    if first is None:
        return
    job = wire.decode(Job, first[1], BUNDLE)
    _redirect(Path(job.log))
    enter(job.environment, Path(job.home))
    limit_by_kernel(job)
    if job.is_sandboxed:
        _go_into_sandbox(job, control.fileno(), data_pipe)
        limit_tasks(job)
    if job.manifest.options.clock == "virtual":  # such runs cannot be late
        os.nice(UNHURRIED)
    else:
        sys.setswitchinterval(SWITCH)
    trace, requests = TracePipe(data_pipe), Control(control)
    requests.start()
    try:
        found = anyio.run(_execute, job, trace, requests)
        status, end = 0, b"" if found is None else pack_end(found)
    except StoppedBefore:
        status, end = NOT_BEGUN, b""
    sys.stdout.flush()  # before the end is reported
    sys.stderr.flush()
    trace.finish(end)
    os._exit(status)  # ends threads of actions, too


def _redirect(log: Path) -> None:
    """Redirect printed output to a file."""
    sys.stdout.flush()
    with log.open("ab") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # for clients that follow the run


def _go_into_sandbox(job: Job, control_pipe: int, data_pipe: int) -> None:
    """Continue in a sandbox; the process outside becomes its broker, and ends with it."""
    ours, theirs = socket.socketpair()
    keys = Path(os.environ[KEYS])
    (Path(job.home) / sandbox.TEMPORARY).mkdir()
    try:
        outer = enter_sandbox(
            sandbox.command(job, [*map(Path, job.hidden), keys]), ours, (control_pipe, data_pipe, theirs.fileno())
        )
    except BackendError as error:
        TracePipe(data_pipe).finish(pack_end(not_started(error)))
        os._exit(0)
    if outer is not None:
        end_as(broker.work(ours, job, outer.process))
    del os.environ[KEYS]
    brokered.use_broker(brokered.Broker(theirs))


async def _execute(job: Job, trace: TracePipe, requests: Control) -> End | None:
    try:
        return await _run(job, trace, requests)
    except (InvalidScenario, UsageError, BackendError) as error:
        return not_started(error)
    except StoppedBefore:
        raise
    except Exception as error:
        traceback.print_exc()
        found = cause_of(error)
        return not_started(BackendError(f"internal error of the executor: {type(found).__name__}: {found}"))
    finally:
        requests.detach()


async def _run(job: Job, trace: TracePipe, requests: Control) -> End | None:
    task = asyncio.current_task()
    assert task is not None, "called in a task"
    if job.manifest.options.leasing.wait is not None:  # may wait for robots before the run exists
        requests.on_end(
            lambda kind, _: kind is not Frame.HALT and task.get_loop().call_soon_threadsafe(task.cancel)
        )
    try:
        return await _run_unless_stopped(job, trace, requests)
    except asyncio.CancelledError:
        raise StoppedBefore from None


async def _run_unless_stopped(job: Job, trace: TracePipe, requests: Control) -> End | None:
    """Execute a run; returns its end, or None for a successful dry run."""
    scenario, options = load_run(job, trace, requests)
    if job.campaign is not None:
        await make_runs(job, job.campaign, scenario, options, trace, requests)
        raise StoppedBefore
    manifest, loop = job.manifest, asyncio.get_running_loop()
    async with prepare(scenario, options) as run:
        if job.is_dry:
            values, texts = to_json(run.parameters).encode(), to_json(run.parameter_texts).encode()
            result = DryRunResult(seed=run.seed, parameters=values, texts=texts)
            trace.send(Frame.DRY_RUN_RESULT, wire.encode(result))
            return None
        trace.send(Frame.BEGIN, announcement(run, options))
        end: dict[Frame, Callable[[str], object]] = {
            Frame.STOP: partial(_stop, run),
            Frame.HALT: run.halt,
            Frame.ABORT: run.abort,
        }
        requests.on_end(lambda kind, reason: loop.call_soon_threadsafe(end[kind], reason))
        limit = limit_of(manifest.options)
        async with (
            _recording(run, manifest.options.film, Path(job.output)) as recording,
            nullcontext() if run.simulator is None else serving_pictures(run.simulator, Path(job.home)),
            run.running(limit),
            background() as tasks,
        ):
            emitter = Emitter(run, tasks, partial(trace.send, Frame.EMITTED))
            requests.on_emission(lambda data: loop.call_soon_threadsafe(emitter.emit, data))
            await run.result()
            requests.on_emission(lambda data: None)
        left = await _leave(run, recording, Path(job.output))
    assert run.verdict is not None, "the run is over"
    fault = run.fault
    return Ended(
        verdict=run.verdict if recording is None else recording.checked(run.verdict),
        parameters=run.parameters,
        files=left,
        fault="" if fault is None else fault_text(fault),
        traceback="" if fault is None else "".join(traceback.format_exception(fault)),
    )


def _stop(run: Run, reason: str) -> None:
    """Stop a run, and limit the time of its clean-up."""
    run.stop(reason)
    asyncio.get_running_loop().call_later(AFTER_STOP, run.halt, reason)


def _recording(run: Run, film: BundledFilm | None, output: Path) -> AbstractAsyncContextManager[Recording | None]:
    """Record the requested video while the block lasts."""
    return nullcontext() if film is None else run.recording(VideoOptions(**film.model_dump()), output / NAME)


async def _leave(run: Run, recording: Recording | None, output: Path) -> tuple[ResultFile, ...]:
    """Write artifacts of the simulator into the output folder; returns all output files."""
    left = [ResultFile(file.path.relative_to(output).as_posix(), file.description) for file in run.files]
    if recording is not None:
        left.append(ResultFile(NAME, DESCRIPTION))
    for artifact in await run.artifacts():
        path = output / Path(artifact.name).name
        path.write_bytes(artifact.data)
        left.append(ResultFile(path.name, artifact.description, is_artifact=True))
    return tuple(left)
