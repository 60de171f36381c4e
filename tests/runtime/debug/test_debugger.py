"""Pauses and steps of a run, which do not change its trace."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any

import pytest

from seoro.embed.options import Options
from seoro.errors import UsageError
from seoro.runtime.debug.breakpoints import Breakpoint
from seoro.runtime.debug.clock import SLICE, DebugClock
from seoro.runtime.debug.debugger import Debugger, Pause, Reason, Step
from seoro.runtime.debug.inspection import branches, globals_of, parts_of, variables_of
from seoro.runtime.kernel import clock as clocks
from seoro.runtime.kernel.clock import SimulatorClock
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import HEADER, Prepare

SCENARIO = """
struct box:
    width: int = 3

global level: int = 5

scenario part:
    rounds: int = 2
    do serial:
        first: wait elapsed(1s)
        log("in part")

scenario main:
    held: box
    var count: int = 0
    do serial:
        begin: log("begin")
        both: parallel:
            inner: part()
            branch: serial:
                increment(count)
                second: wait elapsed(2s)
                increment(count)
        finish: log("end")
"""


def line_of(text: str) -> int:
    """Return the line of a text in the scenario file."""
    return next(number for number, line in enumerate((HEADER + SCENARIO).split("\n"), 1) if text in line)


def name_of(pause: Pause) -> str:
    return pause.scope.context.path.rpartition("/")[2] if pause.scope is not None else "time"


@asynccontextmanager
async def debugged(
    prepare_text: Prepare, debugger: Debugger, records: list[dict[str, Any]] | None = None
) -> AsyncIterator[Any]:
    class Keep:
        def record(self, record: dict[str, Any]) -> None:
            if records is not None:
                records.append({name: value for name, value in record.items() if name != "wall"})

    options = Options(seed=1, clock="virtual", observers=(Keep(),), debugger=debugger)
    async with prepare_text(SCENARIO, options) as run, run.running():
        yield run


async def steps(prepare_text: Prepare, debugger: Debugger, step: Step, most: int = 100) -> list[str]:
    """Return the behaviors at which a run pauses; ended ones are marked by ` end`."""
    found: list[str] = []
    async with debugged(prepare_text, debugger) as run, asyncio.timeout(30):
        ended = asyncio.ensure_future(run.result())
        while len(found) < most:
            paused = asyncio.ensure_future(debugger.wait_paused())
            await asyncio.wait({ended, paused}, return_when=asyncio.FIRST_COMPLETED)
            if not paused.done():
                paused.cancel()
                break
            pause = paused.result()
            found.append(name_of(pause) + (" end" if pause.has_ended else ""))
            debugger.resume(step)
        debugger.release()
        await ended
    return found


async def test_stepping_through_all_records_does_not_change_the_trace(prepare_text: Prepare) -> None:
    free: list[dict[str, Any]] = []
    async with debugged(prepare_text, Debugger(), free) as run:
        await run.result()
    stepped: list[dict[str, Any]] = []
    debugger = Debugger(stop_on_entry=True)
    debugger.on_pause = lambda _: asyncio.get_running_loop().call_soon(debugger.resume, Step.RECORD)
    async with debugged(prepare_text, debugger, stepped) as run:
        assert (await run.result()).passed
    assert stepped == free


async def test_each_start_and_end_is_a_record_to_step_to(prepare_text: Prepare) -> None:
    found = await steps(prepare_text, Debugger(stop_on_entry=True), Step.RECORD)
    assert found[:4] == ["main", "serial[0]", "begin[0]", "begin[0] end"]
    assert len(found) == 2 * 13


async def test_steps_to_instants_pause_once_at_each_time(prepare_text: Prepare) -> None:
    found = await steps(prepare_text, Debugger(stop_on_entry=True), Step.INSTANT)
    assert found == ["main", "first[0] end", "second[1] end"]


async def test_steps_over_stay_in_their_branch(prepare_text: Prepare) -> None:
    debugger = Debugger(stop_on_entry=True)
    found = await steps(prepare_text, debugger, Step.INTO, 3)
    assert found == ["main", "serial[0]", "begin[0]"]
    debugger = Debugger()
    debugger.on_pause = lambda _: None
    async with debugged(prepare_text, debugger) as run, asyncio.timeout(30):
        await _pause_at(debugger, "begin: log")
        debugger.resume(Step.OVER)
        assert name_of(await debugger.wait_paused()) == "both[1]"
        debugger.resume(Step.OVER)
        assert name_of(await debugger.wait_paused()) == "finish[2]"
        debugger.resume()
        await run.result()


async def test_steps_into_enter_invocations_and_branches(prepare_text: Prepare) -> None:
    debugger = Debugger()
    async with debugged(prepare_text, debugger) as run, asyncio.timeout(30):
        await _pause_at(debugger, "both: parallel")
        debugger.resume(Step.INTO)
        assert name_of(await debugger.wait_paused()) == "inner[0]"
        debugger.resume(Step.OUT)
        assert name_of(await debugger.wait_paused()) == "finish[2]"
        debugger.resume()
        await run.result()


async def _pause_at(debugger: Debugger, text: str) -> Pause:
    """Set a breakpoint before the run begins, and wait for it."""
    await asyncio.sleep(0)
    _set(debugger, {line_of(text): Breakpoint(line_of(text))})
    return await debugger.wait_paused()


def _set(debugger: Debugger, found: dict[int, Breakpoint]) -> None:
    span = debugger.services.plan.scenarios["main"].span
    assert span.file.path is not None
    debugger.breakpoints.replace(span.file.path.resolve(), found)


async def test_a_breakpoint_pauses_before_its_line_is_executed(prepare_text: Prepare) -> None:
    debugger = Debugger()
    records: list[dict[str, Any]] = []
    async with debugged(prepare_text, debugger, records) as run, asyncio.timeout(30):
        pause = await _pause_at(debugger, 'log("in part")')
        assert (pause.reason, pause.time) == (Reason.BREAKPOINT, 1.0)
        assert not any(record["kind"] == "log" and record["message"] == "in part" for record in records)
        debugger.resume()
        await run.result()


async def test_a_paused_run_shows_its_branches_and_variables(prepare_text: Prepare) -> None:
    debugger = Debugger()
    async with debugged(prepare_text, debugger) as run, asyncio.timeout(30):
        pause = await _pause_at(debugger, 'log("in part")')
        services = debugger.services
        found = branches(services, {})
        assert [each.frames[0].name for each in found] == ["log", "second"]
        assert [frame.name for frame in found[0].frames[-3:]] == ["both", "serial", "main"]
        assert "until 2.000 s" in found[1].activity
        assert pause.scope is not None
        assert {each.name: each.text for each in variables_of(pause.scope)} == {"rounds": "2"}
        outer = found[1].frames[0].scope
        held, count = variables_of(outer)
        assert (held.text, count.text, count.type_name) == ("box(width: 3)", "1", "int")
        assert [(each.name, each.text) for each in parts_of(held.value, services)] == [("width", "3")]
        assert [(each.name, each.text) for each in globals_of(services)] == [("level", "5")]
        debugger.resume()
        await run.result()


async def test_a_paused_run_can_be_stopped(prepare_text: Prepare) -> None:
    debugger = Debugger(stop_on_entry=True)
    async with debugged(prepare_text, debugger) as run, asyncio.timeout(30):
        await debugger.wait_paused()
        run.stop("enough")
        verdict = await run.result()
    assert (verdict.status, verdict.reason) == (RunStatus.CANCELLED, "enough")


async def test_the_real_clock_cannot_be_paused(prepare_text: Prepare) -> None:
    with pytest.raises(UsageError, match="a run on the real clock cannot be paused"):
        async with prepare_text(SCENARIO, Options(clock="real", debugger=Debugger())):
            pass


class Server:
    """Simulator of which only the time matters."""

    def __init__(self) -> None:
        self.grants: list[float] = []
        self.during: Callable[[], object] = lambda: None

    async def advance(self, until: float) -> float:
        self.grants.append(until)
        self.during()
        return until


async def test_time_passes_in_slices_after_which_it_can_stop() -> None:
    server, debugger = Server(), Debugger()
    pauses: Sequence[Pause] = []
    clock = DebugClock(SimulatorClock(server, float("inf")), debugger)
    debugger.begin(_Services(clock))  # type: ignore[arg-type] # the time is all that is needed
    server.during = debugger.pause
    debugger.on_pause = lambda pause: (pauses.append(pause), asyncio.get_running_loop().call_soon(debugger.resume))  # type: ignore[attr-defined]
    interrupt = asyncio.Event()
    await clock.pass_time(5.0, interrupt)
    assert (clock.now(), pauses) == (SLICE, [])
    server.during = lambda: None
    await clock.pass_time(5.0, interrupt)
    assert [(pause.reason, pause.scope) for pause in pauses] == [(Reason.PAUSE, None)]
    assert server.grants == [SLICE, 2 * SLICE]
    await clock.pass_time(0.25, interrupt)
    assert server.grants[-1] == 0.25


class _Services:
    def __init__(self, clock: DebugClock) -> None:
        self._clock = clock

    @property
    def scheduler(self) -> _Services:
        return self

    @property
    def now(self) -> float:
        return self._clock.now()


async def test_a_pause_does_not_count_for_the_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = [0.0]
    monkeypatch.setattr(clocks, "time", SimpleNamespace(monotonic=lambda: wall[0]))
    clock = SimulatorClock(Server(), 1.0)
    clock.start()
    wall[0] = 100.0  # paused
    clock.resume()
    assert clock._wall_start == 100.0
