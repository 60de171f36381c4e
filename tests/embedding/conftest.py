"""Scenarios for programs that embed seoro, and what a program must find as it was."""

from __future__ import annotations

import asyncio
import gc
import locale
import logging
import os
import random
import signal
import sys
import threading
import warnings
from collections import Counter
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import seoro
from seoro import ActionContext, action

TEXT = """import osc.types
import osc.helpers

action work:
    name: string

action serve

scenario main:
    pace: speed with:
        keep(it in [1mps..5mps])
    do parallel:
        serial:
            wait elapsed([1s..9s])
            log("drawn")
        with:
            repeat(3)
        one_of:
            serial:
                work(name: "left")
                work(name: "more")
            work(name: "right")
        serial:
            wait elapsed([2s..4s])
            log("in between")
            wait elapsed(1s)
        serve() with:
            until elapsed(8s)
"""


@action("work")
async def work(ctx: ActionContext, name: str) -> None:
    """Waits for the run's clock, for the loop, for a thread and for a process, and cleans up in the loop."""
    ctx.log(f"{name} begins")
    try:
        await ctx.sleep(0.5)
        await asyncio.sleep(0)
        await asyncio.to_thread(len, name)
        process = await asyncio.create_subprocess_exec("/bin/true")
        try:
            await process.wait()
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()
    finally:
        await asyncio.sleep(0)
        ctx.log(f"{name} ends")


@action("serve", open_ended=True)
async def serve(ctx: ActionContext) -> None:
    """Has a task, a thread's file and a socket of its own, for as long as it is let."""
    # asyncio itself loses a server whose start is cancelled; one that does not serve yet has no such moment.
    server = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0, start_serving=False)
    async with server, asyncio.TaskGroup() as group:
        group.create_task(server.serve_forever())
        with Path(os.devnull).open(encoding="utf-8"):
            while True:
                await ctx.sleep(60.0)


def load_text(folder: Path, text: str = TEXT) -> seoro.Scenario:
    """The scenario of a text, with the actions above."""
    path = folder / "main.osc"
    path.write_text(text)
    module = ModuleType("actions_of_the_program")
    vars(module).update(work=work, serve=serve)
    return seoro.load(path, modules=[module])


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    """A scenario that draws, waits, and has actions with tasks, files, sockets, threads and processes."""
    return load_text(tmp_path)


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str], seoro.Scenario]:
    """Loads a text."""
    return lambda text: load_text(tmp_path, text)


Records = list[dict[str, Any]]


def without_stamps(records: Sequence[dict[str, Any]]) -> Records:
    """A trace without the stamps of the machine's clock."""
    return [{name: value for name, value in record.items() if name != "wall"} for record in records]


def state_of_the_program() -> dict[str, object]:
    """Return global state that a library must not change."""
    return {
        "signals": {number: signal.getsignal(number) for number in signal.valid_signals()},
        "logging": (
            list(logging.root.handlers),
            logging.root.level,
            logging.root.manager.disable,
            logging.getLogger("asyncio").handlers,
            logging.getLogger("asyncio").level,
            logging.getLoggerClass(),
        ),
        "path": list(sys.path),
        "meta_path": list(sys.meta_path),
        "path_hooks": list(sys.path_hooks),
        "argv": list(sys.argv),
        "folder": Path.cwd(),
        "environment": dict(os.environ),
        "streams": (sys.stdin, sys.stdout, sys.stderr),
        "hooks": (sys.excepthook, sys.unraisablehook, threading.excepthook, sys.gettrace(), sys.getprofile()),
        "recursion": sys.getrecursionlimit(),
        "switch": sys.getswitchinterval(),
        "warnings": list(warnings.filters),
        "garbage": (gc.isenabled(), gc.get_threshold(), gc.get_debug()),  # frozen objects may still be freed
        "random": random.getstate(),
        "locale": locale.setlocale(locale.LC_ALL),
        "umask": _umask(),
    }


def state_of_the_loop() -> dict[str, object]:
    """Return state of the running loop that a library must not change."""
    loop = asyncio.get_running_loop()
    return {
        "loop": loop,
        "exceptions": loop.get_exception_handler(),
        "factory": loop.get_task_factory(),
        "debug": loop.get_debug(),
        "generators": sys.get_asyncgen_hooks(),
    }


@asynccontextmanager
async def as_it_was() -> AsyncIterator[None]:
    """After the block, everything is as it was before, and nothing is left that was not there."""
    await asyncio.to_thread(len, "")  # the first thread of the loop's executor may bring a file
    gc.collect()  # nothing of other tests is to go in the meantime
    loops = [thread.name for thread in threading.enumerate() if thread.name.startswith("asyncio-portal-")]
    assert not loops, "the loop of another test runs in a thread; expected that it ends with its package"
    before, held = (state_of_the_program(), state_of_the_loop()), holdings()
    yield
    assert (state_of_the_program(), state_of_the_loop()) == before
    left = holdings() - held
    assert not left


def _umask() -> int:
    mask = os.umask(0o77)
    os.umask(mask)
    return mask


def holdings() -> Counter[str]:
    """Return the tasks, threads, children and files of this process, without asyncio's own threads."""
    # Threads of asyncio's executor stay. Threads that wait for processes end a moment after them.
    own = ("asyncio", "waitpid-")
    threads = (thread.name for thread in threading.enumerate() if not thread.name.startswith(own))
    return Counter(
        [
            *(f"task {task.get_name()}" for task in asyncio.all_tasks()),
            *(f"thread {name}" for name in threads),
            *(f"child {number}" for number in _children()),
            *(f"file {name}" for name in _files()),
        ]
    )


async def left_of_simulations(held: Counter[str]) -> Counter[str]:
    """Return new holdings; threads of Zenoh get time to close the files of ended sessions."""
    deadline = asyncio.get_running_loop().time() + 10.0  # they take milliseconds; a busy machine may take long
    while (left := holdings() - held) and asyncio.get_running_loop().time() < deadline:
        await asyncio.sleep(0.01)
    return left


def _children() -> list[str]:
    found = []
    for file in Path("/proc/self/task").glob("*/children"):
        with suppress(FileNotFoundError, ProcessLookupError):  # the thread has ended
            found += file.read_text().split()
    return found


def _files() -> list[str]:
    found = []
    for entry in Path("/proc/self/fd").iterdir():
        try:
            found.append(str(entry.readlink()))
        except FileNotFoundError:
            continue  # that of the listing itself
    return found
