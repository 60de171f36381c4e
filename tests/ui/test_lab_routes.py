"""Routes of the lab, with a real simulator node and a real executor."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import ClientConnection

from seoro.ui.server import SiteOptions
from tests.executors import LONG, RunningExecutor
from tests.lab.nodes import Hall, hall_at
from tests.ui.browsing import DEADLINE, Browser, opened
from tests.ui.conftest import serving


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with hall_at(tmp_path_factory.mktemp("hall")) as running:
        yield running


@pytest.fixture(scope="module")
def browser(hall: Hall, lab: RunningExecutor, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A browser of a site with a lab file."""
    folder = tmp_path_factory.mktemp("with-lab")
    file = folder / "lab.yaml"
    file.write_text(
        f"simulators:\n  hall: {{connect: '{hall.endpoint}'}}\nrobots:\n  tb2: {{in: hall, as: second}}\n"
    )
    with (
        serving(SiteOptions((folder,), folder / "state", lab.endpoint, lab=file)) as served,
        opened(served.access) as browser,
    ):
        yield browser


def until(socket: ClientConnection, fits: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    while True:
        found: dict[str, Any] = json.loads(socket.recv(DEADLINE))
        if fits(found):
            return found


def robot(snapshot: dict[str, Any], name: str) -> dict[str, Any]:
    found = [robot for member in snapshot["members"] for robot in member["robots"] if robot["name"] == name]
    return found[0] if found else {}


def test_a_page_leases_and_stops_robots(browser: Browser) -> None:
    with browser.socket("/api/lab") as socket:
        first = until(socket, lambda found: robot(found, "tb2"))
        assert [member["kind"] for member in first["members"]] == ["mujoco", "executor"]
        assert (robot(first, "tb2")["real"], robot(first, "tb2")["state"]) == (False, "free")
        leased = browser.post("/api/lab/lease", {"robots": ["tb2"], "seconds": 60, "purpose": "<img onerror=x>"})
        assert leased.json()["outcomes"] == [{"name": "tb2", "error": "", "done": "leased"}]
        found = until(socket, lambda found: robot(found, "tb2")["state"] == "leased")
        assert robot(found, "tb2")["lease"] == leased.json()["lease"]
        assert robot(found, "tb2")["holder"].startswith("<img onerror=x>")
        (outcome,) = browser.post("/api/lab/end-lease", {"lease": leased.json()["lease"]}).json()["outcomes"]
        assert (outcome["error"], outcome["done"]) == ("", "released")
        until(socket, lambda found: robot(found, "tb2")["state"] == "free")
        (outcome,) = browser.post("/api/lab/stop", {"robots": ["tb2"]}).json()["outcomes"]
        assert (outcome["name"], outcome["done"]) == ("the node 'hall'", "stopped")


def test_an_emergency_stop_stops_robots_and_runs_until_its_release(
    browser: Browser, lab: RunningExecutor, tmp_path: Path
) -> None:
    (tmp_path / "long.osc").write_text(LONG)
    with browser.socket("/api/lab") as socket:
        until(socket, lambda found: not found["stopped"])
        stopped = browser.post("/api/lab/stop-all", {"reason": "smoke"})
        assert {outcome["name"]: outcome["error"] for outcome in stopped.json()["outcomes"]} == {
            "the node 'hall'": "",
            "the executor 'lab-a'": "",
        }
        found = until(socket, lambda found: found["stopped"] and found["stopped"]["count"] == 2)
        assert (found["stopped"]["reason"], found["stopped"]["of"]) == ("smoke", 2)
        assert robot(found, "tb2")["state"] == "stopped"
        refused = browser.post("/api/lab/release", {"reason": " "})
        assert refused.status_code == 400
        assert "missing reason" in refused.json()["error"]
        released = browser.post("/api/lab/release", {"reason": "the area is clear"})
        assert [outcome["error"] for outcome in released.json()["outcomes"]] == ["", ""]
        until(socket, lambda found: not found["stopped"])


@pytest.mark.parametrize(
    ("path", "data", "message"),
    [
        ("lease", {"robots": []}, "expected names of robots"),
        ("lease", {"robots": "tb2"}, "expected a list of names"),
        ("lease", {"robots": ["tb2"], "seconds": -1}, "invalid `seconds`"),
        ("lease", {"robots": ["tb2"], "duration": 60}, "unknown field `duration`"),
        ("end-lease", {"name": "none"}, "unknown field `name`"),
        ("lease", {"robots": ["tb9"]}, "unknown robot 'tb9'"),
        ("stop", {"robots": ["tb9"]}, "unknown robot 'tb9'"),
        ("end-lease", {"lease": "none"}, "unknown lease or leased robot 'none'"),
        ("release", {"reason": "x", "robots": ["tb2"]}, "no emergency stop of 'second'"),
    ],
)
def test_invalid_requests_are_refused(browser: Browser, path: str, data: object, message: str) -> None:
    answer = browser.post(f"/api/lab/{path}", data)
    assert answer.status_code == 400
    assert message in answer.json()["error"]
