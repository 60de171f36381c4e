"""Cost of reports: size, time and memory to write one, time to open it, frames while the time moves.

    python benchmarks/ui.py [--records N]

Needs Chromium and playwright. Prints a table for the demo-sized trace and for one of a million records.
"""

from __future__ import annotations

import argparse
import gzip
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path
from tempfile import SpooledTemporaryFile

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from seoro.report.following import TraceFile
from seoro.report.live import LiveRun
from seoro.ui.feeds import PIECE
from tests.report.traces import many_records

STATIC = Path(__file__).parents[1] / "seoro/report/static"
WRITE = "import sys; from seoro.cli.main import main; sys.exit(main(sys.argv[1:]))"
TABS = ("Source", "Log", "Records", "Plots", "Values")
STEPS = 200
FRAMES = """
async () => {
  const slider = document.getElementById("time");
  const gaps = [];
  let last = await new Promise(requestAnimationFrame);
  for (let step = 1; step <= 200; step++) {
    slider.value = String(50 * step);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    const now = await new Promise(requestAnimationFrame);
    gaps.push(now - last);
    last = now;
  }
  return gaps.sort((a, b) => a - b)[189];
}
"""


def write(folder: Path, count: int) -> tuple[float, float, int, int]:
    """Write a trace and its report; returns processor time [s], memory [MiB], and both sizes [bytes]."""
    trace, report = folder / f"{count}.jsonl", folder / f"{count}.html"
    with trace.open("w", encoding="utf-8") as file:
        file.writelines(json.dumps(record, ensure_ascii=False) + "\n" for record in many_records(count))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    show = "print(*[line for line in open('/proc/self/status') if line.startswith('VmHWM')], file=sys.stderr)"
    code = WRITE.replace("sys.exit(main(sys.argv[1:]))", f"main(sys.argv[1:]); {show}")
    command = [sys.executable, "-c", code, "report", str(trace), "-o", str(report)]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return took, int(done.stderr.split()[-2]) / 1024, trace.stat().st_size, report.stat().st_size


def open_served(trace: Path) -> tuple[float, float]:
    """Open a run as `seoro ui` does, in another process; returns processor time [s] and memory [MiB]."""
    code = "import sys; from benchmarks.ui import read_served; read_served(sys.argv[1])"
    done = subprocess.run([sys.executable, "-c", code, str(trace)], stdout=subprocess.PIPE, check=True)
    took, memory = map(float, done.stdout.split())
    return took, memory


def read_served(trace: str) -> None:
    """Open a run, and print processor time [s] and memory [MiB], without those of the start."""
    began, start = _peak(), time.process_time()
    run = LiveRun()
    with closing(TraceFile(Path(trace), run)) as file, SpooledTemporaryFile(PIECE) as frame:
        while file.poll():
            pass
        file.finish()
        run.write_frame(frame.write)
    print(time.process_time() - start, _peak() - began)


def _peak() -> float:
    """Return the most memory that this process had [MiB]."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.partition("VmHWM:")[2].split()[0]) / 1024


def open_in(browser: Browser, path: Path) -> tuple[float, ...]:
    """Open a report; returns first paint and ready [s], heap [MB], and for each tab the numbers of `move`."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    start = time.perf_counter()
    page.goto(path.as_uri(), wait_until="commit")
    page.locator("html[data-ready]").wait_for(state="attached")
    ready = time.perf_counter() - start
    page.wait_for_timeout(1000)
    paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN")
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    heap = session.send("Runtime.getHeapUsage")
    used = (heap["usedSize"] + heap.get("backingStorageSize", 0)) / 1e6
    session.send("Performance.enable")
    moved = [move(page, session, tab) for tab in TABS]
    page.close()
    return paint / 1000, ready, used, *(value for each in moved for value in each)


def move(page: Page, session: CDPSession, tab: str) -> tuple[float, float]:
    """Move the time on a tab; returns the 95th percentile of a frame, and the time of scripts for one [ms]."""
    page.get_by_role("tab", name=tab).click()
    page.wait_for_timeout(500)
    before = _script_time(session)
    frame = page.evaluate(FRAMES)
    return frame, 1000 * (_script_time(session) - before) / STEPS


def _script_time(session: CDPSession) -> float:
    found = session.send("Performance.getMetrics")["metrics"]
    return next(float(each["value"]) for each in found if each["name"] == "ScriptDuration")


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--records", type=int, default=1_000_000)
    options = parser.parse_args()
    built = [(STATIC / name).read_bytes() for name in ("report.js", "report.css")]
    print(f"pages: {sum(len(gzip.compress(data)) for data in built) / 1000:.0f} kB gzip")
    with tempfile.TemporaryDirectory() as place, sync_playwright() as playwright:
        folder = Path(place)
        for count in (1_000, options.records):
            took, memory, size, report = write(folder, count)
            print(f"{count:,} records, {size / 1e6:.1f} MB: report of {report / 1e6:.2f} MB, ", end="")
            print(f"{took:.1f} s of a processor, {memory:.0f} MiB")
            first, later = open_served(folder / f"{count}.jsonl"), open_served(folder / f"{count}.jsonl")
            print(f"  seoro ui: {first[0]:.1f} s of a processor and {first[1]:.0f} MiB more to read it, ", end="")
            print(f"{later[0]:.2f} s and {later[1]:.0f} MiB more from the cache")
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            best = [
                min(values)
                for values in zip(*(open_in(browser, folder / f"{count}.html") for _ in range(3)), strict=True)
            ]
            browser.close()
            paint, ready, heap, *moved = best
            print(f"  first paint {paint:.2f} s, ready {ready:.2f} s, {heap:.0f} MB")
            for tab, frame, script in zip(TABS, moved[::2], moved[1::2], strict=True):
                print(f"  {tab}: frame {frame:.1f} ms (95 %), script {script:.1f} ms")


if __name__ == "__main__":
    main()
