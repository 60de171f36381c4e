"""Starting runs from the form of a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.executors import NAME
from tests.ui.browsing import Browser

FORM = """# Waits, and logs.
# seoro: seed 5

import osc.types
import osc.helpers

enum colour: [red, green]

struct place:
    x: length
    y: length = 2m

scenario first:
    # Time until the end.
    pause: time
    keep(pause in [100ms..700ms])
    speed: speed = 3kph
    shade: colour = colour!green
    goal: place
    is_loud: bool = false
    do serial:
        wait elapsed(pause)
        log("done")

scenario needy:
    goal: place
    do serial:
        log("hello")

# The other one.
scenario second:
    do serial:
        log("hello")
"""
FILE = "form/form.osc"


@pytest.fixture(scope="package")
def form(folder: Path) -> Path:
    path = folder / FILE
    path.parent.mkdir()
    path.write_text(FORM)
    (path.parent / "broken.osc").write_text("scenario broken\n    do\n")
    return path


def test_scenarios_are_listed(browser: Browser, form: Path) -> None:
    found = [each for each in browser.get("/api/scenarios")["scenarios"] if each["file"] == FILE]
    assert [(each["name"], each["doc"]) for each in found] == [
        ("first", "Waits, and logs."),
        ("needy", "Waits, and logs."),
        ("second", "The other one."),
    ]
    [broken] = [each for each in browser.get("/api/scenarios")["scenarios"] if each["file"] == "form/broken.osc"]
    assert (broken["name"], broken["line"]) == ("", 1)
    assert broken["problem"].startswith("line 1: ")


def test_the_form_of_a_scenario_has_its_parameters(browser: Browser, form: Path) -> None:
    found = browser.get(f"/api/scenario?file={FILE}&name=first")
    parameters = {each.pop("path"): each for each in found["parameters"]}
    assert list(parameters) == ["pause", "speed", "shade", "goal.x", "goal.y", "is_loud"]
    pause = parameters["pause"]
    assert (pause["type"], pause["unit"], pause["doc"]) == ("time", "s", "Time until the end.")
    assert (pause["minimum"], pause["maximum"], pause["required"]) == (0.1, 0.7, False)
    assert (parameters["speed"]["unit"], parameters["speed"]["default"]) == ("m/s", "3kph")
    assert parameters["shade"]["choices"] == ["colour!red", "colour!green"]
    assert pause["choices"] is None
    assert parameters["is_loud"]["choices"] == ["true", "false"]
    needed = browser.get(f"/api/scenario?file={FILE}&name=needy")["parameters"]
    assert [(each["path"], each["required"]) for each in needed] == [("goal.x", True), ("goal.y", False)]
    assert (found["seed"], found["needsSimulator"]) == (5, False)


def test_invalid_scenarios_have_a_problem(browser: Browser, form: Path) -> None:
    assert "broken.osc:1" in browser.get("/api/scenario?file=form/broken.osc&name=broken")["problem"]
    assert "nothing" in browser.get(f"/api/scenario?file={FILE}&name=nothing")["problem"]
    assert browser.http.get("/api/scenario?file=../etc/passwd&name=x").status_code == 404
    assert browser.http.get("/api/scenario").status_code == 404


def test_a_form_starts_a_run(browser: Browser, form: Path) -> None:
    values = {"pause": "100ms", "goal.x": "1m", "shade": "colour!red", "speed": ""}
    data = {"file": FILE, "scenario": "first", "place": NAME, "seed": "7", "timeout": 30, "set": values}
    answer = browser.post("/api/start", data)
    assert answer.status_code == 200, answer.text
    run = answer.json()["run"]
    found = browser.run(lambda each: each["id"] == run and each["status"] == "passed")
    assert (found["scenario"], found["place"], found["kind"]) == ("first", NAME, "executor")
    assert found["file"].endswith("form.osc")


@pytest.mark.parametrize(
    ("changes", "field", "error"),
    [
        ({"place": "nowhere"}, "place", "unknown executor 'nowhere'"),
        ({"file": "nothing.osc"}, "file", "unknown scenario file"),
        ({"file": "form/broken.osc"}, "file", "broken.osc:1"),
        ({"file": 7}, "file", "expected a text"),
        ({"scenario": "third"}, "scenario", "third"),
        ({"seed": "x"}, "seed", "expected a whole number from 0"),
        ({"seed": -1}, "seed", "expected a whole number from 0"),
        ({"timeout": "0"}, "timeout", "expected seconds above 0"),
        ({"rate": "fast", "simulator": "mujoco"}, "rate", "expected a number above 0, or max"),
        ({"rate": 1}, "simulator", "need a simulator"),
        ({"simulator": "none"}, "simulator", "no simulator `none`"),
        ({"set": {"pause": 3}}, "pause", "expected an expression"),
        ({"set": {"goal.x": "1m", "pause": "3"}}, "pause", ""),
        ({"set": {"goal.x": "1m", "pause": "3s"}}, "pause", ""),
        ({"set": {"goal.x": "1m", "pause": "1 +"}}, "pause", ""),
        ({"set": {"goal.x": "1m", "unknown": "1"}}, "unknown", "unknown parameter"),
        ({"scenario": "needy", "set": {}}, "goal.x", "missing value of `goal.x`"),
    ],
)
def test_errors_name_the_field(
    browser: Browser, form: Path, changes: dict[str, Any], field: str, error: str
) -> None:
    data = {"file": FILE, "scenario": "first", "place": NAME, "set": {"goal.x": "1m"}}
    answer = browser.post("/api/start", {**data, **changes})
    assert answer.status_code in (400, 404), answer.text
    assert answer.json().get("field", "") == field
    assert error in answer.json()["error"]
