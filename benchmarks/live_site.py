"""Delay of the data of a growing trace at a page of `seoro ui`, and its cost for the server.

    python benchmarks/live_site.py [--rate N] [--seconds N] [--page]

A process writes records at a rate, without a run. A client reads the frames as a page does. With `--page`, a page
in Chromium reads them; this needs playwright.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path

from playwright.sync_api import CDPSession, sync_playwright

from seoro.ui.security import Access
from seoro.ui.server import SiteOptions
from tests.ui.browsing import DEADLINE, Browser, next_frame, opened
from tests.ui.conftest import serving

WRITER = """
import json, sys, time
path, rate, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
with open(path, "ab", buffering=0) as file:
    began, number = time.time(), 0
    print(began, flush=True)
    while (elapsed := time.time() - began) < seconds:
        lines = []
        while number < elapsed * rate:
            number += 1
            record = {"seq": number, "t": time.time() - began, "kind": "variable", "path": "x.v", "value": number}
            lines.append(json.dumps(record) + "\\n")
        file.write("".join(lines).encode())
        time.sleep(0.01)
    end = {"seq": number + 1, "t": seconds, "kind": "run.end", "status": "passed", "reason": ""}
    file.write(json.dumps(end).encode() + b"\\n")
"""
START = {"seq": 0, "t": 0.0, "kind": "run.start", "scenario": "x", "file": "x.osc", "format": "1.1"}


WATCH = """
window.frames_ = [];
const Plain = window.WebSocket;
window.WebSocket = class extends Plain {
  constructor(...given) {
    super(...given);
    if (!String(given[0]).includes("/api/run/")) return;
    this.addEventListener("message", ({ data }) => {
      if (typeof data === "string") return;
      const stop = data.byteLength - 4; // frames of these runs have one piece
      const length = new DataView(data).getUint32(stop, true);
      const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(data, stop - length, length)));
      const [size, time, count, end] = [data.byteLength, meta.time ?? 0, meta.count ?? 0, meta.end ?? null];
      requestAnimationFrame(() => window.frames_.push([Date.now() / 1000, time, count, size, end?.seq ?? 0]));
    });
  }
};
"""


@dataclass(frozen=True)
class Arrival:
    """Arrival of a frame.

    Args:
        at: Time of its arrival at a client, or of its picture on a page [s].
        time: Time of its last record [s].
        count: Number of records until then.
        size: Its size [bytes].
        end: Number of the last record of the run; 0 before it is there.
    """

    at: float
    time: float
    count: int
    size: int
    end: int


@contextmanager
def writing(trace: Path, rate: int, seconds: float) -> Iterator[float]:
    """Write records while the block lasts; yields the time at which this began [s since the epoch]."""
    command = [sys.executable, "-c", WRITER, str(trace), str(rate), str(seconds)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        yield float(process.stdout.readline())


def by_client(browser: Browser, run: str, start: Callable[[], AbstractContextManager[float]]) -> list[Arrival]:
    """Follow the run with a client; returns the arrivals, with times since the beginning."""
    found: list[Arrival] = []
    with browser.socket(f"/api/run/{run}") as socket:
        next_frame(socket)
        with start() as began:
            while not found or not found[-1].end:
                data, columns = next_frame(socket)
                end = (data.get("end") or {}).get("seq", 0)
                found.append(Arrival(time.time() - began, data.get("time", 0), data["count"], len(columns), end))
    return found


def by_page(
    browser: Browser, access: Access, run: str, start: Callable[[], AbstractContextManager[float]]
) -> list[Arrival]:
    """Follow the run with a page in Chromium; prints its processor time, returns the arrivals once it is open."""
    with start() as began, sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        page = chromium.new_page(viewport={"width": 1280, "height": 900}, bypass_csp=True)
        page.add_init_script(WATCH)
        page.goto(access.url)
        page.goto(f"{browser.origin}/run/{run}")
        page.locator(".transport").wait_for()
        system = chromium.new_browser_cdp_session()
        opened, used = time.time(), _processor_time(system)
        page.wait_for_function("window.frames_.at(-1)?.[4] > 0", timeout=1000 * DEADLINE)
        took = time.time() - opened
        for kind, seconds in _processor_time(system).items():
            print(f"processor time of Chromium, {kind}: {seconds - used.get(kind, 0):.2f} s in {took:.1f} s")
        arrivals = [Arrival(at - began, *more) for at, *more in page.evaluate("window.frames_") if at > opened]
        chromium.close()
    return arrivals


def _processor_time(system: CDPSession) -> Counter[str]:
    found: Counter[str] = Counter()
    for process in system.send("SystemInfo.getProcessInfo")["processInfo"]:
        found[process["type"]] += process["cpuTime"]
    return found


def show(found: list[Arrival]) -> None:
    """Print the delays: of the last record in each frame, and of all records."""
    assert found[-1].end == found[-1].count - 1, "no record is lost"
    size = sum(arrival.size for arrival in found)
    print(f"records: {found[-1].count:,} in {len(found)} frames with {size / 1e6:.1f} MB")
    latest = [arrival.at - arrival.time for arrival in found]
    every: list[float] = []
    for before, arrival in pairwise(found):
        count = arrival.count - before.count
        step = (arrival.time - before.time) / max(count, 1)
        every += [arrival.at - arrival.time + step * number for number in range(count)]
    for name, delays in (("latest record of a frame", sorted(latest)), ("all records", sorted(every))):
        median, late = (1000 * delays[int(share * len(delays))] for share in (0.5, 0.99))
        print(f"delay, {name}: median {median:.0f} ms, 99th percentile {late:.0f} ms")


def main() -> None:
    """Print the delay of records, and the processor time of the server."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rate", type=int, default=20_000, help="records per second")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--page", action="store_true", help="follow the run with a page in Chromium")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trace = folder / "run" / "trace.jsonl"
        trace.parent.mkdir()
        trace.write_text(json.dumps(START) + "\n")
        site = SiteOptions((folder,), folder / "state", f"unixsock-stream/{folder}/nobody")
        start = partial(writing, trace, options.rate, options.seconds)
        with serving(site) as served, opened(served.access) as browser:
            run = browser.run(lambda run: True)["id"]
            used = time.process_time()
            found = by_page(browser, served.access, run, start) if options.page else by_client(browser, run, start)
            used = time.process_time() - used
    show(found)
    print(f"processor time of server and client: {used:.2f} s in {options.seconds:g} s")


if __name__ == "__main__":
    main()
