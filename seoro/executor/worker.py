"""The process of a run, which `template.py` makes.

It takes its job, carries it out as a program that embeds seoro does, tells what happens, and ends. When the pipe
for its job ends, its executor is gone: the run is stopped and cleans up, and whatever hangs then ends with the
process.
"""

from __future__ import annotations

import asyncio
import io
import os
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import IO, Final

import anyio

# Most runs have a simulator: to load what that takes is to take no time of theirs.
import seoro.bridges.launch
import seoro.bridges.wire.everything  # noqa: F401
from seoro.bridges import wire
from seoro.bridges.executor.messages import BUNDLE, BundledFilm, Tried
from seoro.bridges.session import brokered
from seoro.bundle.places import locating
from seoro.bundle.unpacking import limit_of, options_of
from seoro.embed import announcement, check_file, prepare
from seoro.embed.ends import End, Ended, LeftFile, not_run, pack_end
from seoro.embed.runs import Run
from seoro.embed.scenarios import Scenario
from seoro.errors import BackendError, InvalidScenario, InvalidUse
from seoro.executor import broker, sandbox
from seoro.executor.entering import end_as
from seoro.executor.entering import enter as enter_sandbox
from seoro.executor.environment import enter
from seoro.executor.frames import NOT_BEGUN, Frame, Job, read_frame
from seoro.executor.kernel_limits import limit_by_kernel, limit_tasks
from seoro.executor.policy import keeping_to, reader_of, vet_endpoints, vet_plan, vet_sources
from seoro.executor.telling import Telling
from seoro.film import DESCRIPTION, NAME, Film, Recording
from seoro.keys.folder import VARIABLE as KEYS
from seoro.lang.loader import Reader
from seoro.located import Locate
from seoro.reasons import fault_text
from seoro.runtime.jsonl import to_json

UNHURRIED: Final = 19  # niceness of runs on the virtual clock, for the sake of those that may be late
SWITCH: Final = 0.0002  # [s] for which the run may keep other threads from working
AFTER_STOP: Final = 20.0  # [s] that robots may take to be left in order once a run was asked to stop
ORPHANED: Final = 15.0  # [s] for the clean-up of a run whose executor is gone


class Orders:
    """That a run is to go on, or to stop, also before there is one. From a thread that reads the pipe.

    Args:
        control: The pipe.
    """

    def __init__(self, control: IO[bytes]) -> None:
        self._control = control
        self._lock = threading.Lock()
        self._reason: str | None = None
        self._is_halted = False
        self._is_given_up = False
        self._stop: Callable[[str], object] | None = None
        self._halt: Callable[[str], object] = lambda reason: None
        self._give_up: Callable[[str], object] | None = None
        self._go: Callable[[], object] = lambda: None

    def start(self) -> None:
        """Begin to listen."""
        threading.Thread(target=self._listen, name="listens to the executor", daemon=True).start()

    def when_asked(
        self,
        stop: Callable[[str], object],
        halt: Callable[[str], object] = lambda reason: None,
        give_up: Callable[[str], object] | None = None,
    ) -> None:
        """Have something called, in another thread, with the reason; at once if it was said already.

        Args:
            stop: Stops the run.
            halt: Has nothing done after it, in addition.
            give_up: Ends the run as an error; by default, `stop` does.
        """
        with self._lock:
            self._stop, self._halt, self._give_up = stop, halt, give_up or stop
            if self._reason is not None:
                (self._give_up if self._is_given_up else stop)(self._reason)
                if self._is_halted:
                    halt(self._reason)

    def end(self) -> None:
        """Have nothing called any more: the run is over, and soon so is its event loop."""
        with self._lock:
            self._stop, self._halt, self._give_up = None, lambda reason: None, None

    async def turn(self, ask: Callable[[], object]) -> None:
        """Ask for a turn, and wait for it."""
        loop, has_it = asyncio.get_running_loop(), asyncio.Event()
        self._go = lambda: loop.call_soon_threadsafe(has_it.set)
        ask()
        await has_it.wait()

    def _listen(self) -> None:
        while (frame := read_frame(self._control)) is not None:
            if frame[0] is Frame.GO:
                self._go()
            else:
                self.ask(frame[1].decode(), frame[0])
        self.ask("the executor is gone", Frame.HALT)
        time.sleep(ORPHANED)
        os._exit(1)

    def ask(self, reason: str, how: Frame = Frame.STOP) -> None:
        """Stop the run.

        Args:
            reason: Why.
            how: `STOP`, `HALT` or `GIVE_UP`.
        """
        with self._lock:
            if self._reason is None:
                self._reason, self._is_given_up = reason, how is Frame.GIVE_UP
                end = self._give_up if self._is_given_up else self._stop
                if end is not None:
                    end(reason)
            if how is Frame.HALT:
                self._is_halted = True
                self._halt(reason)


class StoppedBefore(Exception):
    """A run was stopped before it began."""


def work(control_pipe: int, data_pipe: int) -> None:
    """Wait for a job, carry it out, and end the process.

    Args:
        control_pipe: Open descriptor of the pipe for the job.
        data_pipe: That of the pipe for what is told of it.
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
    if job.manifest.options.clock == "virtual":  # it is never late, and there may be many such runs
        os.nice(UNHURRIED)
    else:
        sys.setswitchinterval(SWITCH)
    telling, orders = Telling(data_pipe), Orders(control)
    orders.start()
    try:
        found = anyio.run(_carry_out, job, telling, orders)
        status, end = 0, b"" if found is None else pack_end(found)
    except StoppedBefore:
        status, end = NOT_BEGUN, b""
    sys.stdout.flush()  # before clients are told that all is there
    sys.stderr.flush()
    telling.finish(end)
    os._exit(status)  # all is cleaned up; what a thread of an action still does ends with the run


def _redirect(log: Path) -> None:
    """Have what is printed go to a file."""
    sys.stdout.flush()
    with log.open("ab") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # for those who follow the run


def _go_into_sandbox(job: Job, control_pipe: int, data_pipe: int) -> None:
    """Have the rest of this done in a sandbox; the process outside is the broker of it, and ends with it."""
    ours, theirs = socket.socketpair()
    keys = Path(os.environ[KEYS])
    (Path(job.home) / sandbox.TEMPORARY).mkdir()
    try:
        outer = enter_sandbox(
            sandbox.command(job, [*map(Path, job.hidden), keys]), ours, (control_pipe, data_pipe, theirs.fileno())
        )
    except BackendError as error:
        Telling(data_pipe).finish(pack_end(not_run(error)))
        os._exit(0)
    if outer is not None:
        end_as(broker.work(ours, job, outer.process))
    del os.environ[KEYS]
    brokered.use(brokered.Broker(theirs))


async def _carry_out(job: Job, telling: Telling, orders: Orders) -> End | None:
    try:
        return await _run(job, telling, orders)
    except (InvalidScenario, InvalidUse, BackendError) as error:
        return not_run(error)
    except StoppedBefore:
        raise
    except Exception as error:
        traceback.print_exc()
        found = error.exceptions[0] if isinstance(error, ExceptionGroup) else error
        return not_run(BackendError(f"internal error of the executor: {type(found).__name__}: {found}"))
    finally:
        orders.end()


async def _run(job: Job, telling: Telling, orders: Orders) -> End | None:
    task = asyncio.current_task()
    assert task is not None, "this is one"
    if job.manifest.options.leasing.wait is not None:  # for robots, until which there is no run
        orders.when_asked(lambda reason: task.get_loop().call_soon_threadsafe(task.cancel))
    try:
        return await _run_unless_stopped(job, telling, orders)
    except asyncio.CancelledError:
        raise StoppedBefore from None


async def _run_unless_stopped(job: Job, telling: Telling, orders: Orders) -> End | None:
    """How a run ended; None of a dry run that could be."""
    files, manifest = Path(job.files), job.manifest
    os.chdir(files / manifest.directory)
    read, locate = reader_of(files), locating(manifest.root, files)
    load = partial(_checked, read=read, locate=locate, job=job)
    scenario = load(files / manifest.entry, manifest.shown)
    loop = asyncio.get_running_loop()
    asked = options_of(manifest, _as_seen_from(Path(manifest.directory)), locate)
    options = replace(
        asked,
        leasing=replace(asked.leasing, say=telling.wait, turn=partial(orders.turn, telling.be_ready)),
        observers=(telling,),
        output_directory=Path(job.output),
        vet=partial(vet_plan, allowed=job.allowed),
        locate=keeping_to((files, Path(job.output)), locate, job.allowed),
        load=lambda path: load(locate(path), str(path)),
    )
    vet_endpoints(options, job.allowed, job.reach)
    async with prepare(scenario, options) as run:
        if job.is_dry:
            values, texts = to_json(run.parameters).encode(), to_json(run.parameter_texts).encode()
            tried = Tried(seed=run.seed, parameters=values, texts=texts)
            telling.tried(wire.encode(tried))
            return None
        telling.begin(announcement(run, options))
        orders.when_asked(
            lambda reason: loop.call_soon_threadsafe(_stop, run, reason),
            lambda reason: loop.call_soon_threadsafe(run.halt, reason),
            lambda reason: loop.call_soon_threadsafe(run.give_up, reason),
        )
        limit = limit_of(manifest.options)
        async with _recording(run, manifest.options.film, Path(job.output)) as recording, run.running(limit):
            await run.result()
        left = await _leave(run, recording, Path(job.output))
    assert run.verdict is not None, "it was waited for"
    fault = run.fault
    return Ended(
        verdict=run.verdict if recording is None else recording.checked(run.verdict),
        parameters=run.parameters,
        files=left,
        fault="" if fault is None else fault_text(fault),
        traceback="" if fault is None else "".join(traceback.format_exception(fault)),
    )


def _checked(path: Path, shown: str, read: Reader, locate: Locate, job: Job) -> Scenario:
    """A scenario of the bundle, which may be run here."""
    vet = partial(vet_sources, allowed=job.allowed)
    return check_file(path, name=shown, read=read, locate=locate, vet=vet).without_errors()


def _stop(run: Run, reason: str) -> None:
    """Stop a run, and what is done after it in time."""
    run.stop(reason)
    asyncio.get_running_loop().call_later(AFTER_STOP, run.halt, reason)


def _as_seen_from(directory: Path) -> Path:
    """The root of a bundle from a folder in it, so that messages call files as the user does."""
    return Path(*[".."] * len(directory.parts))


def _recording(run: Run, film: BundledFilm | None, output: Path) -> AbstractAsyncContextManager[Recording | None]:
    """Record what is asked for while the block lasts."""
    return nullcontext() if film is None else run.recording(Film(**film.model_dump()), output / NAME)


async def _leave(run: Run, recording: Recording | None, output: Path) -> tuple[LeftFile, ...]:
    """What a run leaves in its output folder, with what its simulator has to show."""
    left = [LeftFile(file.path.relative_to(output).as_posix(), file.description) for file in run.files]
    if recording is not None:
        left.append(LeftFile(NAME, DESCRIPTION))
    for artifact in await run.artifacts():
        path = output / Path(artifact.name).name
        path.write_bytes(artifact.data)
        left.append(LeftFile(path.name, artifact.description, is_artifact=True))
    return tuple(left)
