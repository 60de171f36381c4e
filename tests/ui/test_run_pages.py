"""Pages of runs in a real browser: the list, and a run, live."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from seoro.ui.server import Served
from tests.chromium import launched, violations_of
from tests.executors import LONG, RunningExecutor
from tests.report.traces import HOSTILE, REVERSED, records, write
from tests.ui.pages import Opened, opened, shows
from tests.ui.test_runs import submitted

if TYPE_CHECKING:
    from playwright.async_api import Browser, Locator, WebSocketRoute

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def chromium() -> AsyncIterator[Browser]:
    async with launched() as found:
        yield found


async def open_run(found: Opened, name: str) -> None:
    """Open a run by a link in the list."""
    await found.page.get_by_label("search").fill(name)
    await found.page.locator(".run-row .what a").first.click()
    await found.page.get_by_role("tabpanel").wait_for()


async def has_value(field: Locator, value: re.Pattern[str]) -> None:
    """Wait until a field has a value."""
    from playwright.async_api import expect

    await expect(field).to_have_value(value, timeout=30_000)


async def test_a_run_is_found_and_its_views_are_read_back(
    chromium: Browser, served: Served, hello: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.ui.feeds.PIECE", 300)  # frames have many pieces
    async with opened(chromium, served.access) as found:
        page = found.page
        row = page.locator(".run-row", has_text="hello.osc").first
        await shows(row, "Passed")
        await page.get_by_label("search").fill("no such run")
        await page.get_by_text("No run matches").wait_for()
        await page.get_by_label("search").fill("hello passed")
        await page.get_by_label("status").select_option("failed")
        await page.get_by_text("No run matches").wait_for()
        await page.get_by_label("status").select_option("")
        await page.locator(".run-row .what a").first.click()
        await page.get_by_role("heading", name="hello").wait_for()
        assert await page.title() == "Passed: hello · seoro"
        assert 'log("hello")' in await found.tab("Source")
        await found.tab("Log")
        await page.get_by_role("option").get_by_text("hello").wait_for()
        await found.tab("Records")
        await page.get_by_role("option").get_by_text("The run passed").wait_for()
        await shows(page.get_by_role("tree"), "log")
        await page.go_back()
        await page.get_by_role("heading", name="Runs").wait_for()
        assert found.problems == []


async def test_a_run_is_followed_and_stopped(
    chromium: Browser, served: Served, lab: RunningExecutor, tmp_path: Path
) -> None:
    run = await asyncio.to_thread(submitted, lab, LONG, tmp_path)
    async with opened(chromium, served.access) as found:
        page = found.page
        await found.go(f"/run/x{run}")
        await page.locator(".badge", has_text="Running").wait_for()
        await page.get_by_role("button", name="Live").wait_for()
        time = page.get_by_label("Time in seconds")
        await has_value(time, re.compile(r"^(0\.[2-9]|[1-9])"))  # it follows the end
        await time.fill("0.1")
        await time.press("Enter")
        await page.get_by_role("button", name="Go live").wait_for()
        await page.get_by_role("button", name="Stop…").click()
        dialog = page.get_by_role("dialog")
        await dialog.get_by_label("Reason").fill("seen enough")
        await dialog.get_by_role("button", name="Stop the run").click()
        await page.locator(".badge", has_text="Cancelled").wait_for()
        await shows(page.locator(".reason"), "seen enough")
        assert await time.input_value() == "0.100"
        assert await page.get_by_role("button", name="live").count() == 0
        assert found.problems == []


async def test_a_run_without_behaviors_shows_those_that_start(
    chromium: Browser, served: Served, folder: Path
) -> None:
    start, *rest = records("before its first behavior")
    trace = write(folder / "results" / "starting", [start])
    async with opened(chromium, served.access) as found:
        page = found.page
        await open_run(found, "before its first")
        await page.get_by_text("No behavior started.").wait_for()
        with trace.open("a") as file:
            file.writelines(json.dumps(record) + "\n" for record in rest)
        await page.get_by_role("tree").wait_for()
        assert await page.get_by_role("heading", name="Timeline").count() == 1
        assert found.problems == []


async def test_a_lost_connection_is_shown_and_mended(chromium: Browser, served: Served, hello: Path) -> None:
    async with opened(chromium, served.access) as found:
        page = found.page
        sockets: list[WebSocketRoute] = []

        async def forward(socket: WebSocketRoute) -> None:
            sockets.append(socket)
            if len(sockets) == 2:
                await socket.close()  # the first attempt fails, too
            else:
                socket.connect_to_server()

        await page.route_web_socket("**/api/runs", forward)
        await page.reload()
        await page.get_by_text("Connected").wait_for()
        await sockets[0].close()
        await page.get_by_text("The connection is lost").wait_for()
        await page.get_by_text("The connection is lost").wait_for(state="detached")
        await page.get_by_text("Connected").wait_for()
        await page.locator(".run-row", has_text="hello").first.wait_for()
        assert len(sockets) == 3
        assert found.problems == []


async def test_hostile_names_show_as_text_on_narrow_pages(chromium: Browser, served: Served, folder: Path) -> None:
    label = HOSTILE + REVERSED + "x" * 10_000
    write(folder / "hostile", records(label, log=label, robot=HOSTILE))
    async with opened(chromium, served.access, width=360) as found:
        page = found.page
        await page.get_by_label("search").fill("owned")
        row = page.locator(".run-row", has_text="<img src=x")
        await row.wait_for()
        assert "⟨U+202E⟩" in await row.locator("a").inner_text()
        assert await found.width() <= 360
        await row.locator("a").click()
        await page.get_by_role("tabpanel").wait_for()
        for name in ("Log", "Records", "Plots", "Values", "Source"):
            await found.tab(name)
            assert await found.width() <= 360
        assert HOSTILE in await page.locator("h1").inner_text()
        assert await page.title() != "owned"
        assert await page.locator("#app img, #app script").count() == 0
        assert found.problems == []


@pytest.mark.parametrize("width", [1280, 360])
async def test_of_thousands_of_runs_the_visible_ones_are_in_the_page(
    chromium: Browser, served: Served, width: int
) -> None:
    async with opened(chromium, served.access, width=width) as found:
        page = found.page

        def send_many(socket: WebSocketRoute) -> None:
            run = {"place": "here", "kind": "folder", "file": "a.osc", "status": "passed", "reason": "", "by": ""}
            times = {"started": 1.0, "ended": 2.0, "robots": [], "waits": "", "position": None, "mayStop": False}
            runs = [
                {**run, **times, "id": f"r{number}", "scenario": f"run_{number}", "submitted": 10_000.0 - number}
                for number in range(5_000)
            ]
            socket.send(json.dumps({"runs": runs}))

        await page.route_web_socket("**/api/runs", send_many)
        await page.reload()
        await page.get_by_role("link", name="run_0", exact=True).wait_for()
        assert await page.locator("[data-row]").count() < 60
        await page.locator(".run-box").evaluate("box => { box.scrollTop = box.scrollHeight }")
        await page.get_by_role("link", name="run_4999", exact=True).wait_for()
        assert await page.locator("[data-row]").count() < 60
        assert found.problems == []


@pytest.mark.more
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 360])
async def test_axe_finds_no_violations_in_runs(
    chromium: Browser, served: Served, hello: Path, scheme: str, width: int
) -> None:
    async with opened(chromium, served.access, width=width, color_scheme=scheme) as found:
        await found.page.locator("[data-row]").first.wait_for()
        assert await violations_of(found.page) == []
        await open_run(found, "hello")
        assert await found.width() <= width
        for name in ("Source", "Log", "Records", "Plots", "Values"):
            await found.tab(name)
            assert await violations_of(found.page) == []
