"""Reports and output files of runs."""

from __future__ import annotations

from pathlib import Path

from tests.executors import LONG, NAME
from tests.ui.browsing import Browser

SECRET = "not a result"


def run_in(browser: Browser, folder: Path) -> str:
    found: str = browser.run(lambda run: run["folder"] == str(folder))["id"]
    return found


def test_the_report_of_a_run_is_downloaded(browser: Browser, hello: Path) -> None:
    found = browser.http.get(f"/api/run/{run_in(browser, hello)}/report")
    assert found.text.startswith("<!doctype html>")
    assert "<title>passed: hello" in found.text.lower()
    assert found.headers["content-type"] == "application/octet-stream"
    assert found.headers["content-disposition"].startswith("attachment; filename*=UTF-8''hello-")


def test_output_files_are_listed_and_downloaded(browser: Browser, hello: Path) -> None:
    run = run_in(browser, hello)
    files = {each["name"]: each["size"] for each in browser.get(f"/api/run/{run}/files")["files"]}
    assert {"trace.jsonl", "test.xml"} <= files.keys()
    assert files["trace.jsonl"] == (hello / "trace.jsonl").stat().st_size
    found = browser.http.get(f"/api/run/{run}/files/test.xml")
    assert found.content == (hello / "test.xml").read_bytes()
    assert found.headers["content-type"] == "application/octet-stream"


def test_only_results_are_served(browser: Browser, hello: Path) -> None:
    run = run_in(browser, hello)
    (hello / "notes.txt").write_text(SECRET)
    (hello.parent / "secret.txt").write_text(SECRET)
    (hello / "top_down.png").symlink_to(hello.parent / "secret.txt")
    try:
        names = {each["name"] for each in browser.get(f"/api/run/{run}/files")["files"]}
        assert not names & {"notes.txt", "top_down.png"}
        for name in ("notes.txt", "top_down.png", "../secret.txt", "..%2fsecret.txt", "%2e%2e/secret.txt"):
            found = browser.http.get(f"/api/run/{run}/files/{name}")
            assert found.status_code == 404, name
        for name in (str(hello / "trace.jsonl"), ""):
            assert browser.http.get(f"/api/run/{run}/files/{name}").status_code in (307, 404), name
    finally:
        for path in (hello / "notes.txt", hello.parent / "secret.txt", hello / "top_down.png"):
            path.unlink()


def test_results_of_an_executor_are_downloaded(browser: Browser, folder: Path) -> None:
    (folder / "files.osc").write_text(LONG.replace("60s", "0.1s"))
    started = browser.post("/api/start", {"file": "files.osc", "scenario": "long", "place": NAME}).json()
    run = browser.run(lambda each: each["id"] == started["run"] and each["status"] == "passed")["id"]
    names = [each["name"] for each in browser.get(f"/api/run/{run}/files")["files"]]
    assert names[0] == "trace.jsonl"
    trace = browser.http.get(f"/api/run/{run}/files/trace.jsonl").text
    assert trace.startswith('{"seq": 0')
    assert "run.end" in trace
    assert browser.http.get(f"/api/run/{run}/files/none.txt").status_code == 404
    assert "<title>passed: long" in browser.http.get(f"/api/run/{run}/report").text.lower()
