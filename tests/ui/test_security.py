"""Requests that the site does not admit."""

from __future__ import annotations

import http.client
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from websockets.exceptions import InvalidStatus

from seoro.ui.security import LARGEST_BODY, POLICY
from seoro.ui.server import Served
from tests.ui.browsing import Browser


def test_the_url_with_the_token_gives_a_cookie(served: Served) -> None:
    with httpx.Client(base_url=served.access.url.partition("/?")[0]) as client:
        for path in ("/", "/static/ui.js", "/api/site"):
            assert client.get(path).status_code == 401
        assert "open the URL" in client.get("/").text
        assert client.get("/?token=wrong").status_code == 401
        found = client.get(served.access.url)
        assert (found.status_code, found.headers["location"]) == (303, "/")
        assert "HttpOnly" in found.headers["set-cookie"]
        assert "samesite=strict" in found.headers["set-cookie"].lower()
        assert served.access.token not in found.headers["set-cookie"]
        for path in ("/", "/static/ui.js", "/static/ui.css", "/static/world3d.js"):
            assert client.get(path).status_code == 200
        assert client.get("/", headers={"Cookie": "x=1"}).status_code == 401


def test_pages_have_strict_headers(browser: Browser) -> None:
    for path in ("/", "/runs", "/run/x", "/start", "/api/site", "/nothing", "/api/run/none/block/0"):
        headers = browser.http.get(path).headers
        assert headers["content-security-policy"] == POLICY
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cache-control"] == "no-store"
        assert "server" not in headers


@pytest.mark.parametrize("host", ["example.org", "localhost", "127.0.0.1:1", "", "127.0.0.1.example.org"])
def test_foreign_hosts_are_refused(browser: Browser, host: str) -> None:
    assert browser.http.get("/", headers={"Host": host}).status_code in (400, 421)
    assert browser.http.get(browser.access.url, headers={"Host": host}).status_code in (400, 421)


def test_the_own_hosts_are_admitted(browser: Browser) -> None:
    port = browser.access.port
    for host in (f"127.0.0.1:{port}", f"localhost:{port}"):
        assert browser.http.get("/", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize("origin", ["https://example.org", "null", "http://127.0.0.1", ""])
def test_foreign_origins_are_refused(browser: Browser, origin: str) -> None:
    headers = {"Origin": origin}
    assert browser.http.post("/api/run/x/stop", headers=headers).status_code == 403
    assert browser.http.get("/api/site", headers=headers).status_code == 403
    with pytest.raises(InvalidStatus, match="403"), browser.socket("/api/runs", Origin=origin):
        pass


def test_changes_need_an_origin(browser: Browser) -> None:
    assert browser.http.post("/api/run/x/stop").status_code == 403


def test_sockets_need_an_origin_and_the_cookie(browser: Browser) -> None:
    with pytest.raises(InvalidStatus, match="401"), browser.socket("/api/runs", Cookie="x=1"):
        pass
    connection = http.client.HTTPConnection("127.0.0.1", browser.access.port)
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    key = {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Cookie": browser.cookie}
    connection.request("GET", "/api/runs", headers=upgrade | key)
    assert connection.getresponse().status == 403
    connection.close()


def test_large_bodies_are_refused(browser: Browser, hello: Path) -> None:
    def parts() -> Iterator[bytes]:
        for _ in range(LARGEST_BODY // 1000 + 2):
            yield b" " * 1000

    run = browser.run(lambda run: True)
    for content in (b" " * (LARGEST_BODY + 1), parts()):
        found = browser.http.post(
            f"/api/run/{run['id']}/stop", content=content, headers={"Origin": browser.origin}
        )
        assert found.status_code == 413


def test_paths_lead_nowhere_else(browser: Browser) -> None:
    for path in ("/static/..%2fsite.py", "/static/%2e%2e/site.py", "/static//etc/passwd", "/static/source.txt"):
        assert browser.http.get(path).status_code == 404
