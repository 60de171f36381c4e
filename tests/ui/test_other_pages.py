"""Pages of starting, labs, campaigns and comparisons in a real browser."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from seoro.cli.main import main
from seoro.ui import debug_session
from seoro.ui.server import Served, SiteOptions
from tests.bridges.robot.conftest import Rails
from tests.chromium import launched, violations_of
from tests.executors import LONG, RunningExecutor
from tests.lab.nodes import Hall, hall_at
from tests.ui.conftest import serving
from tests.ui.pages import opened, shows
from tests.ui.test_campaigns import SCENARIO
from tests.ui.test_runs import submitted

if TYPE_CHECKING:
    from playwright.async_api import Browser, Page, WebSocketRoute

pytestmark = pytest.mark.asyncio(loop_scope="module")

FORM = """import osc.types
import osc.helpers

enum colour: [red, green]

struct place:
    x: length

scenario first:
    # Time until the end.
    pause: time
    keep(pause in [0.1s..2s])
    speed: speed = 3kph
    shade: colour = colour!green
    goal: place
    do serial:
        wait elapsed(pause)
        log("done")
"""
LOST = 3001  # close code, neither that of an end nor of a replacement
PAGES = ("/runs", "/start", "/lab", "/campaigns", "/compare", "/nowhere")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def chromium() -> AsyncIterator[Browser]:
    async with launched() as found:
        yield found


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with hall_at(tmp_path_factory.mktemp("hall")) as running:
        yield running


@pytest.fixture(scope="module")
def site(
    hall: Hall, lab: RunningExecutor, all_rails: Rails, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Served]:
    """A site with a lab of simulated and real robots, a form, a campaign, and two runs."""
    folder = tmp_path_factory.mktemp("pages")
    lab_file = folder / "lab.yaml"
    lab_file.write_text(
        f"simulators:\n  hall: {{connect: '{hall.endpoint}'}}\n"
        f"bridges:\n  rails: {{connect: '{all_rails.endpoint}'}}\n"
        "robots:\n  tb2: {in: hall, as: second}\n  track: {in: rails, as: line}\n"
    )
    (folder / "form.osc").write_text(FORM)
    (folder / "vary.osc").write_text(SCENARIO)
    campaign = ["campaign", "run", str(folder / "vary.osc"), "-o", str(folder / "vary"), "--clock", "virtual"]
    assert main([*campaign, "--jobs", "1"]) == 1
    for name, pause in (("slow", "2s"), ("fast", "1s")):
        settings = ["--set", f"pause={pause}", "--set", "goal.x=1m", "--clock", "virtual", "--seed", "1"]
        assert main(["exec", str(folder / "form.osc"), "-o", str(folder / name), *settings]) == 0
    with serving(SiteOptions((folder,), folder / "state", lab.endpoint, lab=lab_file)) as served:
        yield served


async def choose_scenario(page: Page, name: str) -> None:
    await page.get_by_label("search").fill(name)
    await page.locator(".scenario", has_text=name).first.click()
    await page.get_by_role("button", name="Start", exact=True).wait_for()


async def test_a_run_is_started_from_the_form_of_its_parameters(chromium: Browser, site: Served) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        await page.get_by_role("link", name="Start", exact=True).click()
        await choose_scenario(page, "first")
        settings = page.get_by_role("region", name="Settings")
        await shows(settings, "pause time [s]")
        await shows(settings, "Time until the end.")
        assert await page.get_by_label("speed").get_attribute("placeholder") == "3kph"
        await page.get_by_label("shade").select_option("colour!red")
        await page.get_by_label("pause").fill("0.2s")
        await page.get_by_label("goal.x").fill("1m")
        await page.get_by_label("speed").fill("3 bananas")
        await page.get_by_role("button", name="Start", exact=True).click()
        await settings.get_by_role("alert").wait_for()
        assert await page.get_by_label("speed").get_attribute("aria-invalid") == "true"
        await page.get_by_label("speed").fill("4kph")
        await page.get_by_role("button", name="Start", exact=True).click()
        await page.locator(".badge", has_text="Passed").wait_for()
        values = await found.tab("Values")
        assert "pause" in values and "red" in values
        assert found.problems == []


async def test_an_emergency_stop_is_one_click_and_its_release_asks(
    chromium: Browser, site: Served, lab: RunningExecutor, tmp_path: Path
) -> None:
    run = await asyncio.to_thread(submitted, lab, LONG, tmp_path)
    async with opened(chromium, site.access) as found:
        page = found.page
        await found.go("/lab")
        real = page.locator(".robot", has_text="track")
        await real.wait_for()
        assert "REAL" in await real.inner_text()
        await shows(page.locator(".robot", has_text="tb2"), "simulated")
        await found.go(f"/run/x{run}")
        await page.locator(".badge", has_text="Running").wait_for()
        await page.get_by_role("button", name="Emergency stop").click()
        banner = page.get_by_role("region", name="Emergency stop")
        await banner.wait_for()
        await page.locator(".badge", has_text="Cancelled").wait_for()
        await found.go("/lab")
        await page.locator(".robot.real", has_text="stopped").wait_for()
        await banner.get_by_role("button", name="Release…").click()
        dialog = page.get_by_role("dialog")
        assert await dialog.get_by_role("button", name="Release").is_disabled()
        await page.keyboard.press("Escape")
        await dialog.wait_for(state="detached")
        await banner.get_by_role("button", name="Release…").click()
        await dialog.get_by_label("Why is it safe?").fill("the area is clear")
        await page.keyboard.press("Enter")
        await banner.wait_for(state="detached")
        await page.locator(".robot.real", has_text="free").wait_for()
        assert found.problems == []


@pytest.mark.more
async def test_a_robot_is_leased_and_stopped_with_confirmation(chromium: Browser, site: Served) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        await found.go("/lab")
        robot = page.locator(".robot", has_text="tb2")
        await robot.get_by_role("button", name="Lease tb2").click()
        await page.get_by_label("Purpose").fill("new <b>wheels</b>")
        await page.get_by_label("Minutes").fill("x")
        await page.get_by_role("button", name="Lease", exact=True).click()
        await page.get_by_text("expected minutes from 1 to 1440").wait_for()
        await page.get_by_label("Minutes").fill("5")
        await page.get_by_role("button", name="Lease", exact=True).click()
        await robot.get_by_text("new <b>wheels</b>").wait_for()
        await robot.get_by_text(re.compile("for (5 min|4 min [0-9]+ s) more")).wait_for()
        await robot.get_by_role("button", name="End the lease of tb2").click()
        await page.get_by_role("button", name="End the lease", exact=True).click()
        await robot.get_by_text("nobody").wait_for()
        await robot.get_by_role("button", name="Stop tb2").click()
        await page.get_by_role("dialog").get_by_role("button", name="Stop", exact=True).click()
        await page.get_by_role("dialog").wait_for(state="detached")
        assert found.problems == []


async def test_a_campaign_leads_to_its_failed_run(chromium: Browser, site: Served) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        await page.get_by_role("link", name="Campaigns").click()
        await page.get_by_role("link", name="vary.osc").click()
        await page.get_by_role("heading", name="Pass rate").wait_for()
        for text in ("4 runs", "75 %", "3 passed, 1 failed."):
            await shows(page.locator("main"), text)
        rows = await page.locator(".outcome").first.locator("tr").all_inner_texts()
        assert "1 of 1 failed" in rows[-1]
        async with page.expect_download() as download:
            await page.get_by_role("link", name="Download report").click()
        assert (await download.value).suggested_filename == "report.html"
        await page.locator(".failures a").first.click()
        await page.locator(".badge", has_text="Failed").wait_for()
        assert found.problems == []


async def test_two_runs_are_compared(chromium: Browser, site: Served) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        await page.get_by_label("search").fill("first form")
        for name in ("slow", "fast"):
            await page.locator("[data-row]", has_text=name).get_by_role("checkbox").check()
        await page.get_by_role("button", name="Compare the 2 chosen").click()
        await page.get_by_role("heading", name="The runs first differ").wait_for()
        verdicts = page.get_by_role("region", name="Verdicts")
        await verdicts.get_by_text("Passed").nth(1).wait_for()
        assert (await verdicts.inner_text()).count("Passed") == 2
        await shows(page.get_by_role("region", name="Settings that differ"), "pause")
        await page.get_by_label("Run B").select_option(index=1)
        assert found.problems == []


@pytest.mark.more
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 360])
async def test_axe_finds_no_violations(chromium: Browser, site: Served, scheme: str, width: int) -> None:
    async with opened(chromium, site.access, width=width, color_scheme=scheme) as found:
        page = found.page
        for path in PAGES:
            await found.go(path)
            await page.locator("main h1").wait_for()
            await page.wait_for_load_state("networkidle")
            assert (path, await violations_of(page)) == (path, [])
            assert (path, await found.width() <= width) == (path, True)
        await found.go("/start")
        await choose_scenario(page, "first")
        await page.get_by_label("Seed").fill("x")
        await page.get_by_role("button", name="Start", exact=True).click()
        await page.locator(".field-problem").wait_for()
        assert await violations_of(page) == []
        await found.go("/campaigns")
        await page.get_by_role("link", name="vary.osc").click()
        await page.get_by_role("heading", name="Pass rate").wait_for()
        assert await violations_of(page) == []
        await found.go("/lab")
        await page.get_by_role("button", name="Lease tb2").click()
        assert await violations_of(page) == []
        assert found.problems == []


async def test_a_debugged_run_stops_at_a_breakpoint_and_outlives_a_reload(chromium: Browser, site: Served) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        await found.go("/start")
        await choose_scenario(page, "first")
        await page.get_by_label("goal.x").fill("1m")
        await page.get_by_label("pause").fill("0.2s")
        await page.get_by_role("button", name="Debug").click()
        panel = page.get_by_role("region", name="Debugger")
        await panel.get_by_text("Paused at the start").wait_for()
        line = FORM.splitlines().index('        log("done")') + 1
        await page.locator(".marks", has_text=str(line)).click()
        await panel.get_by_label(f"Condition of the breakpoint in line {line}").wait_for()
        await panel.get_by_role("button", name="Continue").click()
        await panel.get_by_text("Paused at a breakpoint, 0.200 s").wait_for()
        await panel.locator(".variables li", has_text="shade").wait_for()
        await page.reload()
        await panel.get_by_text("Paused at a breakpoint, 0.200 s").wait_for()
        await panel.get_by_label(f"Condition of the breakpoint in line {line}").wait_for()
        await panel.locator(".variables li", has_text="shade").wait_for()
        await shows(panel.locator(".branches"), "first")
        await panel.get_by_role("button", name="Step over").click()
        await page.locator(".badge", has_text="Passed").wait_for()
        await panel.get_by_text("The run has ended.").wait_for()
        assert found.problems == []


async def test_a_debugger_that_lost_its_connection_opens_it_again(
    chromium: Browser, site: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened(chromium, site.access) as found:
        page = found.page
        sockets: list[WebSocketRoute] = []
        servers: list[WebSocketRoute] = []
        refused = {1, 2}  # attempts

        async def forward(socket: WebSocketRoute) -> None:
            sockets.append(socket)
            if len(sockets) - 1 in refused:
                await socket.close(code=LOST)
            else:
                servers.append(socket.connect_to_server())

        async def lose() -> None:
            await servers[-1].close(code=LOST)
            await sockets[-1].close(code=LOST)

        await page.route_web_socket("**/api/debug*", forward)
        await found.go("/start")
        await choose_scenario(page, "first")
        await page.get_by_label("goal.x").fill("1m")
        await page.get_by_label("pause").fill("0.2s")
        await page.get_by_role("button", name="Debug").click()
        panel = page.get_by_role("region", name="Debugger")
        await panel.get_by_text("Paused at the start").wait_for()
        line = FORM.splitlines().index('        log("done")') + 1
        await page.locator(".marks", has_text=str(line)).click()
        condition = panel.get_by_label(f"Condition of the breakpoint in line {line}")
        await condition.wait_for()
        await lose()
        await panel.get_by_text("The connection is lost").wait_for()
        assert await panel.get_by_role("button", name="Continue").is_disabled()
        await panel.get_by_text("Paused at the start").wait_for()
        assert len(sockets) == 4
        assert await condition.count() == 1
        await panel.get_by_role("button", name="Continue").click()
        await panel.get_by_text("Paused at a breakpoint, 0.200 s").wait_for()
        await panel.locator(".variables li", has_text="shade").wait_for()

        monkeypatch.setattr(debug_session, "RETURN_WITHIN", 0.0)  # the page returns too late
        refused.add(4)
        await lose()
        await panel.get_by_text("The run has ended while the connection was lost.").wait_for()
        await page.locator(".badge", has_text="Cancelled").wait_for()
        assert await panel.get_by_role("button", name="End").is_disabled()
        assert found.problems == []
