"""Executors that end, and come back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from seoro.ui.server import SiteOptions
from tests.executors import HELLO, LONG, NAME, executor
from tests.ui.browsing import Browser, opened
from tests.ui.conftest import serving


def problem_of(site: Any) -> str | None:
    """Return the problem of the executor; None if it is not listed."""
    return next((place["problem"] for place in site["places"] if place["name"] == NAME), None)


def start(browser: Browser, file: str) -> str:
    run: str = browser.post("/api/start", {"file": file, "place": NAME}).raise_for_status().json()["run"]
    return run


@pytest.mark.more
def test_an_executor_that_died_is_shown_and_followed_again(tmp_path: Path) -> None:
    scenarios = tmp_path / "scenarios"
    scenarios.mkdir()
    (scenarios / "hello.osc").write_text(HELLO)
    (scenarios / "long.osc").write_text(LONG)
    with executor(tmp_path) as first:
        options = SiteOptions((scenarios,), tmp_path / "ui", first.endpoint)
        with serving(options) as served, opened(served.access) as browser:
            browser.wait_for("/api/site", lambda site: site["mayStart"])
            run = start(browser, "long.osc")
            browser.run(lambda each: each["id"] == run and each["status"] == "running")
            first.kill()
            browser.wait_for("/api/site", lambda site: bool(problem_of(site)))
            with executor(tmp_path):
                browser.wait_for("/api/site", lambda site: problem_of(site) == "")
                found = browser.run(lambda each: each["id"] == run and each["status"] == "killed")
                assert (found["scenario"], found["mayStop"]) == ("long", False)
                other = start(browser, "hello.osc")
                browser.run(lambda each: each["id"] == other and each["status"] == "passed")
