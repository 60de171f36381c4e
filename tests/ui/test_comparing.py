"""Comparison of two runs in pages."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.client import Client
from tests.executors import HELLO, LONG, NAME, RunningExecutor
from tests.ui.browsing import Browser


def run_named(browser: Browser, end: str) -> str:
    found: str = browser.run(lambda run: run["folder"].endswith(end) and run["status"] == "passed")["id"]
    return found


def test_two_runs_are_compared_as_by_the_command(browser: Browser, folder: Path) -> None:
    (folder / "compared.osc").write_text(
        "import osc.helpers\nscenario compared:\n    n: int = 1\n    do serial:\n"
        '        wait elapsed(1s)\n        log("n is {n}")\n'
    )
    for name, value in (("first", 1), ("second", 2)):
        assert main(["exec", str(folder / "compared.osc"), "--set", f"n={value}", "-o", str(folder / name)]) == 0
    first, second = (run_named(browser, name) for name in ("/first", "/second"))
    found = browser.get(f"/api/compare?a={first}&b={second}")
    assert (found["a"], found["b"]) == (first, second)
    assert ["parameter n", "1", "2"] in found["settings"]
    equal = browser.get(f"/api/compare?a={first}&b={first}")
    assert (equal["settings"], equal["difference"]) == ([], None)


@pytest.mark.anyio
async def test_runs_of_executors_are_compared(
    browser: Browser, lab: RunningExecutor, hello: Path, tmp_path: Path
) -> None:
    (tmp_path / "greeting.osc").write_text(HELLO)
    (tmp_path / "long.osc").write_text(LONG)
    async with Client(lab.endpoint) as client:
        run = await client.submit(NAME, tmp_path / "greeting.osc", seed=0)
        await run.result()
        active = await client.submit(NAME, tmp_path / "long.osc", clock="real")
        remote = browser.run(lambda found: found["id"] == f"x{run.id}" and found["status"] == "passed")["id"]
        local = run_named(browser, "/hello")
        assert browser.get(f"/api/compare?a={remote}&b={remote}")["difference"] is None
        assert browser.get(f"/api/compare?a={local}&b={remote}")["difference"]["first"]["time"] is not None
        browser.run(lambda found: found["id"] == f"x{active.id}")
        refused = browser.http.get(f"/api/compare?a={local}&b=x{active.id}")
        assert (refused.status_code, refused.json()["help"]) == (409, "compare it when it has ended")
        await active.stop("the test is over")


def test_invalid_comparisons_are_refused(browser: Browser, folder: Path, hello: Path) -> None:
    known = run_named(browser, "/hello")
    missing = browser.http.get(f"/api/compare?a={known}")
    assert (missing.status_code, missing.json()["field"]) == (400, "b")
    assert browser.http.get(f"/api/compare?a={known}&b=nobody").status_code == 404
    shutil.copytree(hello, folder / "compared" / "cut")
    trace = folder / "compared" / "cut" / "trace.jsonl"
    trace.write_bytes(b"".join(trace.read_bytes().splitlines(keepends=True)[1:]))
    cut = run_named(browser, "/cut")
    found = browser.http.get(f"/api/compare?a={known}&b={cut}")
    assert (found.status_code, found.json()["help"]) == (400, "compare whole runs")
