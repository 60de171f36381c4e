"""Two people with keys at a lab: one may watch, one may act. TLS, real certificates, a real browser."""

from __future__ import annotations

import json
import shutil
import ssl
import subprocess
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
from websockets.sync.client import connect

from seoro.security.keys.folder import read_keys
from seoro.security.signing.audit_log import check_log
from seoro.ui.listening import Address
from seoro.ui.server import Served, SiteOptions
from tests.chromium import launched, violations_of
from tests.executors import LONG
from tests.labs import NAME, KeyedLab, command, keyed_executor, make_lab
from tests.ui.browsing import DEADLINE
from tests.ui.conftest import serving
from tests.ui.pages import Opened, opened
from tests.ui.test_listening import HOST, certificate_for

if TYPE_CHECKING:
    from playwright.async_api import Browser

pytestmark = [pytest.mark.more, pytest.mark.asyncio(loop_scope="module")]

CERTUTIL = shutil.which("certutil")
OTHER_SCENARIO = LONG.replace("scenario long", "scenario walk").replace("60s", "600s")


@dataclass(frozen=True)
class Lab:
    """A lab with keys, and the site of each person."""

    keys: KeyedLab
    folder: Path
    sites: dict[str, Served]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """An executor and a simulator with keys, and sites of vera (viewer) and anna (operator)."""
    folder = tmp_path_factory.mktemp("people")
    keys = make_lab(folder / "keys")
    certificate = certificate_for(keys, HOST)
    scenarios = folder / "scenarios"
    scenarios.mkdir()
    (scenarios / "walk.osc").write_text(OTHER_SCENARIO)
    with ExitStack() as stack:
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setattr(Address, "is_local", False)
        patch.setenv("XDG_STATE_HOME", str(folder / "simulator"))
        running = stack.enter_context(keyed_executor(folder, keys))
        maze = ["sim", "mujoco", "--world", "hall", "--rate", "1", "--connect", running.endpoint]
        maze += ["--keys", str(keys.keys("maze"))]
        stack.enter_context(command(folder / "maze.log", running.endpoint, *maze))
        sites = {
            person: stack.enter_context(
                serving(
                    SiteOptions(
                        (scenarios,),
                        folder / person,
                        running.endpoint,
                        keys.keys(person),
                        Address(HOST),
                        certificate=certificate,
                    )
                )
            )
            for person in ("vera", "anna")
        }
        yield Lab(keys, folder, sites)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def chromium(lab: Lab, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Browser]:
    """A browser that has imported the certificate of the lab."""
    if CERTUTIL is None:
        pytest.skip("needs certutil, such as by `apt-get install libnss3-tools`")
    home = tmp_path_factory.mktemp("home")
    store = home / ".pki" / "nssdb"
    store.mkdir(parents=True)
    database = ["-d", f"sql:{store}"]
    subprocess.run([CERTUTIL, "-N", *database, "--empty-password"], check=True)
    authority = lab.keys.keys("vera") / "ca.crt"
    subprocess.run([CERTUTIL, "-A", *database, "-n", "lab", "-t", "C,,", "-i", str(authority)], check=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        async with launched() as found:
            yield found


def submitted_by(lab: Lab) -> list[tuple[str, str, str]]:
    """Return the requests in the audit log of the executor: what, by whom, with which outcome."""
    log = lab.folder / "state" / "audit.jsonl"
    check_log(log, read_keys(lab.keys.keys("vera")).authority)
    lines = [json.loads(line) for line in log.read_bytes().splitlines()]
    return [(line["what"], line["by"] or "", line.get("outcome", "")) for line in lines]


async def test_one_person_starts_and_stops_what_another_watches(lab: Lab, chromium: Browser) -> None:
    async with (
        opened(chromium, lab.sites["anna"].access) as anna,
        opened(chromium, lab.sites["vera"].access) as vera,
    ):
        await anna.go("/start")
        await anna.page.get_by_role("button", name="walk").click()
        assert await anna.page.get_by_role("button", name="Debug").is_disabled()
        await anna.page.get_by_role("button", name="Start", exact=False).last.click()
        stop = anna.page.get_by_role("button", name="Stop…", exact=False)
        await stop.wait_for(timeout=1000 * DEADLINE)

        await vera.go("/runs")
        await vera.page.get_by_role("link", name="walk").click(timeout=1000 * DEADLINE)
        await vera.page.get_by_text("begun").first.wait_for(timeout=1000 * DEADLINE)
        assert await _forbidden(vera) == 0
        assert await violations_of(vera.page) == []
        await vera.go("/lab")
        await vera.page.get_by_text("turtlebot4").first.wait_for(timeout=1000 * DEADLINE)
        assert await _forbidden(vera) == 0
        await anna.go("/lab")
        await anna.page.get_by_role("button", name="Lease").first.wait_for(timeout=1000 * DEADLINE)
        await anna.page.go_back()

        await stop.click(timeout=1000 * DEADLINE)
        await anna.page.get_by_role("button", name="Stop the run").click()
        await vera.page.go_back()
        await vera.page.locator(".badge, h1").get_by_text("Cancelled").first.wait_for(timeout=1000 * DEADLINE)
        assert anna.problems == vera.problems == []
    commands = [each for each in submitted_by(lab) if each[0] in ("submit", "stop_run")]
    assert ("submit", "anna", "done") in commands
    assert ("stop_run", "anna", "done") in commands
    assert {by for _, by, _ in commands} == {"anna"}


async def _forbidden(opened: Opened) -> int:
    """Return the number of visible controls that act."""
    names = "Stop…", "Start a run", "Emergency stop", "Lease", "Release…"
    return sum([await opened.page.get_by_role("button", name=name).count() for name in names])


async def test_requests_of_a_watcher_are_refused_by_the_server(lab: Lab, chromium: Browser) -> None:
    async with opened(chromium, lab.sites["vera"].access) as vera:
        send = """async path => {
            const answer = await fetch(path, { method: "POST", body: "{}" });
            return [answer.status, (await answer.json()).error];
        }"""
        for path in ("/api/start", "/api/lab/stop-all", "/api/lab/lease", "/api/run/x/stop"):
            found = await vera.page.evaluate(send, path)
            assert found == [403, "the keys of this site may watch only (role viewer)"]
        site = await vera.page.evaluate("fetch('/api/site').then(answer => answer.json())")
        assert (site["mayStart"], site["mayAct"], site["mayDebug"]) == (False, False, False)
        assert [place["name"] for place in site["places"] if place["kind"] == "executor"] == [NAME]


async def test_debugging_and_secrets_of_other_sites_are_refused(lab: Lab, chromium: Browser) -> None:
    anna, vera = (lab.sites[name].access for name in ("anna", "vera"))
    async with opened(chromium, anna) as page:
        cookies = await page.page.context.cookies()
        other = await page.page.context.new_page()
        # The token of another site, and the cookie of another site, give no access.
        foreign = vera.url.replace(vera.token, anna.token)
        answer = await other.goto(foreign)
        assert answer is not None
        assert answer.status == 401
    context = ssl.create_default_context(cafile=str(lab.keys.keys("vera") / "ca.crt"))
    headers = {"Cookie": "; ".join(f"{each['name']}={each['value']}" for each in cookies)}
    origin = anna.url.partition("/?")[0]
    url = f"{origin.replace('https', 'wss')}/api/debug"
    more = {**headers, "Origin": origin}
    with connect(url, ssl=context, additional_headers=more, proxy=None, open_timeout=DEADLINE) as socket:
        assert "debugs no runs" in json.loads(socket.recv(DEADLINE))["error"]
