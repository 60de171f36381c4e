from __future__ import annotations

import sys
from collections.abc import Awaitable, Callable
from pathlib import Path

import anyio
import pytest

from seoro.cli.report_command import write_file
from seoro.runtime.execution.outputs import TRACE
from tests.chromium import violations_of
from tests.report.conftest import Opened
from tests.report.traces import HOSTILE, REVERSED, many_records, records, write

Open = Callable[..., Awaitable[Opened]]

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def test_a_report_shows_verdict_source_world_and_causes(report: Path, open_report: Open) -> None:
    opened = await open_report(report)
    page = opened.page
    header = await page.locator("header").inner_text()
    assert "Failed" in header
    assert "timeout: still running after 5 s main.osc:12" in header
    assert "wait @go waiting since 2.000 s" in header
    assert "seoro exec main.osc --scenario main --seed 7 --sim mujoco --world hall --rate max" in header
    source = page.get_by_role("tabpanel")
    assert (
        "1 execution, 0 failed, 0 cancelled" in await source.get_by_text('log("begin")').locator("..").inner_text()
    )
    assert "never ran" in await source.get_by_text('log("never")').locator("..").inner_text()
    tree = page.get_by_role("tree")
    assert (await tree.get_by_role("treeitem").all_text_contents())[3:5] == [
        "✓wait elapsed(2s), wait, succeeded",
        "\N{EN DASH}wait @go, wait, cancelled",
    ]

    await opened.set_time(1.25)
    assert (await page.locator(".poses tbody").inner_text()).split() == ["tb4", "1.25", "0.00", "0", "1.00"]
    slider = page.get_by_label("Time of the run")
    await slider.focus()
    await slider.press("End")
    assert (await page.locator(".poses tbody").inner_text()).split()[1] == "5.00"

    await tree.focus()
    for key in ("Home", "ArrowDown", "ArrowDown", "ArrowDown", "ArrowDown", "Enter"):
        await tree.press(key)
    await page.get_by_role("heading", name="2.000 s: wait started").wait_for()
    assert (await page.locator(".causes").inner_text()).splitlines() == [
        "2.000 s because wait succeeded after 2 s main.osc:8",
        "0.000 s because wait started main.osc:8",
        "0.000 s because log succeeded main.osc:7",
        "0.000 s because log started main.osc:7",
        "0.000 s because serial started main.osc:6",
        "0.000 s because main started main.osc:4",
        "0.000 s because The run of main started",
    ]
    assert opened.problems == []


async def test_each_tab_is_read_back(report: Path, open_report: Open) -> None:
    opened = await open_report(report)
    page = opened.page
    await opened.tab("Log")
    await page.get_by_role("option").get_by_text("begin").wait_for()
    await opened.tab("Records")
    await page.get_by_role("option").get_by_text("The run of main started").wait_for()
    await page.get_by_label("search").fill("count = 2")
    await page.get_by_text("1 record", exact=True).wait_for()
    assert "tb4: speed\n[m/s]\n1 m/s" in await opened.tab("Plots")
    await opened.set_time(1)
    assert "not changed yet" in await opened.tab("Values")
    await opened.set_time(3)
    assert "Variables at 3.000 s\ncount\t2" in await opened.tab("Values")
    assert opened.problems == []


async def test_the_world_is_shown_in_three_dimensions(tmp_path: Path, open_report: Open) -> None:
    found = records()
    hits = {"pose": [0.1, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0], "angle_min": 0.0, "angle_increment": 1.5708}
    scan = {"kind": "scan", "time": 1.0, "entity": "tb4", "sensor": "lidar", "ranges": [3.0, None], **hits}
    at = next(number for number, each in enumerate(found) if each["t"] > 1.0)
    found.insert(at, {**found[at - 1], **scan, "t": 1.0})
    write(tmp_path, [{**each, "seq": number} for number, each in enumerate(found)])
    write_file(str(tmp_path / TRACE), tmp_path, tmp_path / "report.html", space=True)
    opened = await open_report(tmp_path / "report.html")
    await opened.set_time(1.0)
    space = opened.page.get_by_role("button", name="3D")
    await space.click()
    picture = opened.page.get_by_role("img", name="World in three dimensions")
    await opened.page.locator('canvas[data-hits="1"]').wait_for()
    assert int(await picture.get_attribute("data-triangles") or 0) > 20  # wall, map, robot and its name
    before = await picture.screenshot()
    await picture.press("ArrowRight")
    assert await picture.screenshot() != before
    await opened.set_time(4.0)
    await opened.page.locator('canvas[data-hits="0"]').wait_for()
    await space.click()
    await opened.page.get_by_role("img", name="World from above").wait_for()
    assert opened.problems == []


async def test_a_trace_without_behaviors_is_shown(tmp_path: Path, open_report: Open) -> None:
    """As `seoro bag --trace` makes it."""
    found = [record for record in records() if record["kind"] in ("run.start", "entity", "poses", "scene")]
    write(tmp_path, [{**each, "seq": number} for number, each in enumerate(found)])
    write_file(str(tmp_path / TRACE), tmp_path, tmp_path / "report.html")
    opened = await open_report(tmp_path / "report.html")
    await opened.page.get_by_text("No behavior started.").wait_for()
    await opened.set_time(1.5)
    assert "tb4" in await opened.page.locator(".poses tbody").inner_text()
    assert await violations_of(opened.page) == []
    assert opened.problems == []


async def test_poses_by_odometry_say_so(tmp_path: Path, open_report: Open) -> None:
    found = [record for record in records() if record["kind"] != "scene"]
    at = next(number for number, each in enumerate(found) if each["kind"] == "poses")
    robot = {"name": "tb4", "kind": "robot", "real": True, "shapes": []}
    changes = [(0.0, {**robot, "frame": "odom"}), (2.0, robot)]
    found[at:at] = [{**found[at], "kind": "entity", "time": time, "entity": entity} for time, entity in changes]
    write(tmp_path, [{**each, "seq": number} for number, each in enumerate(found)])
    write_file(str(tmp_path / TRACE), tmp_path, tmp_path / "report.html", space=True)
    opened = await open_report(tmp_path / "report.html")
    name = opened.page.locator(".poses tbody th")
    await opened.set_time(1.5)
    assert (await name.inner_text()).split() == ["tb4", "real", "by", "odometry"]
    await opened.set_time(2.5)
    assert (await name.inner_text()).split() == ["tb4", "real"]
    await opened.page.get_by_role("button", name="3D").click()
    await opened.page.locator('canvas[data-labels="tb4 (real)"]').wait_for()
    await opened.set_time(1.5)
    await opened.page.locator('canvas[data-labels="tb4 (real, by odometry)"]').wait_for()
    assert opened.problems == []


async def test_a_report_without_three_dimensions_does_not_offer_them(report: Path, open_report: Open) -> None:
    opened = await open_report(report)
    assert await opened.page.get_by_role("button", name="3D").count() == 0


async def test_hostile_texts_show_as_text(tmp_path: Path, open_report: Open) -> None:
    label = HOSTILE + REVERSED + "x" * 10_000
    write(tmp_path, records(label, log=label, robot=HOSTILE))
    write_file(str(tmp_path / TRACE), tmp_path, tmp_path / "report.html")
    opened = await open_report(tmp_path / "report.html", width=360)
    page = opened.page
    for name in ("Log", "Records", "Plots", "Values", "Source"):
        await opened.tab(name)
    assert await page.title() == f"Failed: {label}".replace("\u202e", "\ufffd").replace("\u2066", "\ufffd")
    assert (await page.locator("h1").inner_text()).startswith(HOSTILE)
    assert "⟨U+202E⟩" in await page.locator("h1").inner_text()
    assert await page.locator("#app img, #app script").count() == 0
    assert await page.evaluate("document.documentElement.scrollWidth") <= 360
    assert opened.problems == []


async def test_without_javascript_verdict_tree_and_log_are_readable(report: Path, open_report: Open) -> None:
    opened = await open_report(report, script=False)
    text = await opened.page.locator("main").inner_text()
    assert "Failed: main" in text
    assert "timeout: still running after 5 s (main.osc:12:9)" in text
    assert "    wait (main.osc:9:9): 1 cancelled" in text
    assert "0.000 s info: begin" in text


@pytest.mark.more
@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [1280, 360])
async def test_axe_finds_no_violations(report: Path, open_report: Open, dark: bool, width: int) -> None:
    opened = await open_report(report, dark=dark, width=width)
    await opened.page.get_by_role("tree").press("Enter")
    await opened.page.locator(".detail").wait_for()
    for name in ("Source", "Log", "Records", "Plots", "Values"):
        await opened.tab(name)
        assert await violations_of(opened.page) == []


@pytest.mark.more
async def test_a_run_of_a_million_records(tmp_path: Path, open_report: Open) -> None:
    write(tmp_path, many_records(1_000_000))
    write_file(str(tmp_path / TRACE), tmp_path, tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size < 15_000_000
    opened = await open_report(tmp_path / "report.html")
    page = opened.page
    assert "322,580 behaviors" in await page.locator("#timeline").inner_text()
    await opened.tab("Records")
    await page.get_by_role("listbox").press("End")
    await page.get_by_role("option").get_by_text("The run passed").wait_for()
    await page.get_by_label("show").select_option("failures")
    await page.get_by_text("6 records", exact=True).wait_for()
    await page.locator(".list .line").first.click()
    await page.get_by_role("heading", name="robot.drive_9 failed after 8 ms").wait_for()
    await page.get_by_role("button", name="earlier causes").wait_for()
    assert opened.problems == []


async def test_the_source_is_first_that_of_the_scenario_and_requirements_are_facts(
    tmp_path: Path, open_report: Open
) -> None:
    (tmp_path / "part.osc").write_text("import osc.types\nscenario part:\n    do wait elapsed(1s)\n")
    (tmp_path / "main.osc").write_text(
        'import "part.osc"\n\n# seoro: requirement REQ-1, REQ-2\nscenario main:\n    do part()\n'
    )
    options = ["--scenario", "main", "--clock", "virtual", "--seed", "1", "-o", "out", "--report"]
    await anyio.run_process([sys.executable, "-m", "seoro", "exec", "main.osc", *options], cwd=tmp_path)
    opened = await open_report(tmp_path / "out" / "report.html")
    assert await opened.page.locator(".source select").input_value() == "main.osc"
    assert "requirements REQ-1, REQ-2" in await opened.page.get_by_label("Facts of the run").inner_text()
    assert opened.problems == []
