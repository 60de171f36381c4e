"""Hostile names and slow pages."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.executors import HELLO, MANY, NAME
from tests.ui.browsing import Browser, next_frame

NAMES = ("<img src=x onerror=alert(1)>", "right\u202eto left", "line\nbreak", 'quote"%2f..', "é" * 100)


@pytest.fixture(scope="module")
def hostile(folder: Path) -> Iterator[list[Path]]:
    """Folders with hostile names, each with a run and its scenario; the last one is not UTF-8."""
    names = [os.fsencode(name) for name in NAMES] + [b"not \xff UTF-8"]
    folders = [folder / "strange" / os.fsdecode(name) for name in names]
    for each in folders:
        each.mkdir(parents=True)
        (each / "hello.osc").write_text(HELLO)
        assert main(["exec", str(each / "hello.osc"), "-o", str(each)]) == 0
    yield folders
    shutil.rmtree(folder / "strange")


def _is_in(folder: str, run: dict[str, Any]) -> bool:
    return bool(run["folder"] == folder)


def test_hostile_names_are_data(browser: Browser, hostile: list[Path]) -> None:
    for path in hostile:
        shown = os.fsencode(path).decode("utf-8", "replace").replace("\ufffd", "?")
        run = browser.run(partial(_is_in, shown))
        with browser.socket(f"/api/run/{run['id']}") as opened:
            assert next_frame(opened)[0]["count"] > 0
        found = browser.http.get(f"/api/run/{run['id']}/report")
        assert found.status_code == 200
        assert found.headers["content-disposition"].isascii()
    files = {each["file"] for each in browser.get("/api/scenarios")["scenarios"]}
    for name in NAMES:
        assert f"strange/{name}/hello.osc" in files
        form = browser.http.get("/api/scenario", params={"file": f"strange/{name}/hello.osc", "name": "hello"})
        assert form.json().get("problem") is None


def test_a_page_that_does_not_read_delays_no_other(browser: Browser, folder: Path) -> None:
    (folder / "many.osc").write_text(MANY)
    started = browser.post("/api/start", {"file": "many.osc", "scenario": "many", "place": NAME}).json()
    run = started["run"]
    with browser.socket(f"/api/run/{run}", max_queue=1) as slow, browser.socket(f"/api/run/{run}") as quick:
        count = 0
        while True:
            data = next_frame(quick)[0]
            count = data.get("count", count)
            if data.get("end"):
                break
        assert data["end"]["status"] == "passed"
        late = next_frame(slow)[0]
        while not late.get("end"):
            late = next_frame(slow)[0]
        assert late.get("count") == count
    lines = browser.http.get(f"/api/run/{run}/files/trace.jsonl").text.splitlines()
    assert [json.loads(line)["seq"] for line in lines] == list(range(count))
