"""Delay of the data of a growing trace at a page of `seoro ui`, and its cost for the server.

    python benchmarks/live_site.py [--rate N] [--seconds N]

A process writes records at a rate, without a run. A client reads the frames as a page does.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from seoro.ui.server import SiteOptions
from tests.ui.browsing import DEADLINE, opened, read_frame
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


def main() -> None:
    """Print the delay of frames at the page, and the processor time of the server."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rate", type=int, default=20_000, help="records per second")
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trace = folder / "run" / "trace.jsonl"
        trace.parent.mkdir()
        trace.write_text(json.dumps(START) + "\n")
        site = SiteOptions((folder,), folder / "state", f"unixsock-stream/{folder}/nobody")
        with serving(site) as served, opened(served.access) as browser:
            run = browser.run(lambda run: True)["id"]
            with browser.socket(f"/api/run/{run}") as socket:
                read_frame(socket.recv(DEADLINE))
                command = [sys.executable, "-c", WRITER, str(trace), str(options.rate), str(options.seconds)]
                with subprocess.Popen(command, stdout=subprocess.PIPE) as writer:
                    assert writer.stdout is not None
                    began, used = float(writer.stdout.readline()), time.process_time()
                    delays: list[float] = []
                    size, data = 0, dict[str, Any]()
                    while not data.get("end"):
                        frame = socket.recv(DEADLINE)
                        data, _ = read_frame(frame)
                        delays.append(time.time() - began - data.get("time", 0.0))
                        size += len(frame)
                    used = time.process_time() - used
    assert data["end"]["seq"] == data["count"] - 1, "no record is lost"
    delays.sort()
    print(f"records: {data['count']:,} in {len(delays)} frames with {size / 1e6:.1f} MB")
    median, late = delays[len(delays) // 2], delays[int(0.99 * len(delays))]
    print(f"delay: median {1000 * median:.0f} ms, 99th percentile {1000 * late:.0f} ms")
    print(f"processor time of server and page: {used:.2f} s in {options.seconds:g} s")


if __name__ == "__main__":
    main()
